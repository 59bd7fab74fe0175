#!/usr/bin/env bash
# Installs what building needs and is missing (Debian and its relatives). Does nothing, and needs no
# network, when all is there. With --dev also what developing needs: formatter, linter, git, shells whose
# completions are tested; with --package what packing needs, with --bench what scripts/bench.sh needs, with
# --arm64 what scripts/arm64.sh needs.
set -euo pipefail

packages=(g++ cmake ninja-build libeigen3-dev libceres-dev libopenmesh-dev libcli11-dev
          libgtest-dev libgmock-dev libyaml-cpp-dev nlohmann-json3-dev libsuitesparse-dev libfmt-dev
          libstb-dev libxxhash-dev libtinyobjloader-dev libbenchmark-dev zlib1g-dev libhdf5-dev
          pkgconf man-db)
case "${1:-}" in
    "") ;;
    --dev) packages+=(ccache clang clang-format clang-tidy git libclang-rt-dev libomp-dev
                       dpkg-dev file fish zsh) ;;
    --package) packages+=(dpkg-dev file) ;;
    --bench) packages+=(python3) ;;
    --arm64) packages+=(g++-aarch64-linux-gnu googletest qemu-user) ;;
    *) echo "usage: scripts/setup.sh [--dev|--package|--bench|--arm64]" >&2; exit 2 ;;
esac

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "setup: no apt here, so nothing is installed. Building needs the equivalents of these" >&2
    echo "setup: Debian 12 packages: ${packages[*]}" >&2
    exit 0
fi

missing=()
for package in "${packages[@]}"; do
    status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
    [[ $status == installed ]] || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
    exit 0
fi

as_root=()
if ((EUID != 0)); then
    if ! command -v sudo >/dev/null; then
        echo "setup: missing ${missing[*]}" >&2
        echo "setup: install them as root, or install sudo" >&2
        exit 1
    fi
    as_root=(sudo)
fi
echo "setup: installing ${missing[*]}" >&2
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -q
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -q --no-install-recommends "${missing[@]}"
