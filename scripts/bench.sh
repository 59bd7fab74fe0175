#!/usr/bin/env bash
# Builds the benchmarks, runs them and writes docs/benchmarks/*.json, the plots beside them and the
# generated part of docs/benchmarks.md. An hour or more, on a machine that does nothing else.
#   scripts/bench.sh                   ours alone
#   scripts/bench.sh --torch FILE      and in turn with the PyTorch step of FILE
#   scripts/bench.sh --large           also 200,000 and 1,000,000 vertices (20 GiB)
#   scripts/bench.sh --quick           two minutes, into build/bench/quick: does all of it work?
#   --rounds N   turns of ours and PyTorch's (3)      --only steps|kernels|others|page
set -euo pipefail
cd "$(dirname "$0")/.."

quick= large= torch= rounds=3 only= steps_options=()
usage() { sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 2; }
while (($# > 0)); do
    case "$1" in
        --quick) quick=1 rounds=1; steps_options+=(--quick) ;;
        --large) large=1; steps_options+=(--large) ;;
        --torch) (($# > 1)) || usage; torch=$2; shift ;;
        --rounds) (($# > 1)) || usage; rounds=$2; shift ;;
        --only) (($# > 1)) || usage; only=$2; shift ;;
        *) usage ;;
    esac
    shift
done
[[ -z $only || $only =~ ^(steps|kernels|others|page)$ ]] || usage
wanted() { [[ -z $only || $only == "$1" ]]; }

build=build/bench
out=docs/benchmarks page=docs/benchmarks.md
if [[ $quick ]]; then
    out=$build/quick page=$build/quick/benchmarks.md
fi
mkdir -p "$out"

# Benchmarks by name, and the JSON file of each; those that a version lacks are passed over.
others=(reconstruct:reconstruct geodesic:geodesic reader:readers extract:extract
        consistency:consistency)
programs=()
add_programs() {
    for each in "$@"; do
        if [[ -f tests/bench/${each}_bench.cpp ]]; then programs+=("${each}_bench"); fi
    done
}
if wanted steps; then add_programs step spectral_step; fi
if wanted kernels; then add_programs kernel; fi
if wanted others && [[ ! $quick ]]; then add_programs "${others[@]%%:*}"; fi

scripts/setup.sh --bench
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DMSCOMP_BENCH=ON >/dev/null
if ((${#programs[@]} > 0)); then
    cmake --build "$build" ${JOBS:+-j "$JOBS"} --target "${programs[@]}" >&2
fi
export GOMP_SPINCOUNT=${GOMP_SPINCOUNT-20000}

# The Python that has torch: not always the first on the path.
with_torch() { [[ -n $1 ]] && "$1" -c 'import torch, scipy' 2>/dev/null; }
if [[ $torch ]]; then
    for python in "${PYTHON:-}" /usr/bin/python3 python3; do
        with_torch "$python" && break
        python=
    done
    if [[ $python ]]; then
        steps_options+=(--torch "$torch" --python "$python")
    else
        echo "bench: no Python with torch and scipy (Debian: python3-torch python3-scipy)," >&2
        echo "bench: so there is no comparison; PYTHON names another one" >&2
    fi
fi

run_bench() {  # PROGRAM JSON [OPTION...]
    echo "bench: $1" >&2
    if "$build/bin/$1" --benchmark_out="$out/$2.json.new" --benchmark_out_format=json \
        "${@:3}" >&2; then
        python3 scripts/benchmarks/host.py "$build" "$out/$2.json.new"
        mv "$out/$2.json.new" "$out/$2.json"
    else
        echo "bench: $1 failed, $out/$2.json stays as it was" >&2
        rm -f "$out/$2.json.new"
    fi
}

if wanted steps; then
    python3 scripts/benchmarks/steps.py --build "$build" --out "$out" --rounds "$rounds" \
        "${steps_options[@]}"
fi
if wanted kernels; then
    if [[ $quick ]]; then
        run_bench kernel_bench kernels --benchmark_min_time=0.02
    else
        run_bench kernel_bench kernels --benchmark_repetitions=5 \
            --benchmark_report_aggregates_only=true
    fi
fi
if wanted others && [[ ! $quick ]]; then
    for each in "${others[@]}"; do
        options=()
        [[ $large && $each == geodesic:* ]] && options=(--large)
        if [[ -x $build/bin/${each%%:*}_bench ]]; then
            run_bench "${each%%:*}_bench" "${each##*:}" "${options[@]}"
        fi
    done
fi
python3 scripts/benchmarks/page.py --page docs/benchmarks.md --to "$page" --out "$out" \
    "${others[@]##*:}"
echo "bench: figures in $out, tables in $page" >&2
