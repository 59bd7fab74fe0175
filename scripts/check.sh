#!/usr/bin/env bash
# Is every file of ours formatted, and does clang-tidy find nothing? Changes no file.
#   scripts/check.sh            everything
#   scripts/check.sh FILE...    these sources only
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh --dev
if (($# > 0)); then
    files=("$@")
else
    mapfile -t files < <(git ls-files 'include/*.h' 'src/*.h' 'src/*.cpp' 'tests/*.h' 'tests/*.cpp' \
                                     'docs/*.cpp')
fi
echo "check: format of ${#files[@]} files" >&2
clang-format --dry-run --Werror "${files[@]}"

# Headers are looked at through the sources that include them; tests are formatted, not tidied.
mapfile -t sources < <(printf '%s\n' "${files[@]}" | grep -E '^src/.*\.cpp$' || true)
if ((${#sources[@]} > 0)); then
    # One command per source, which joined sources do not have.
    cmake --preset release -B build/check -DMSCOMP_JOIN=OFF -DBUILD_TESTING=OFF >/dev/null
    echo "check: clang-tidy on ${#sources[@]} sources" >&2
    printf '%s\0' "${sources[@]}" |
        xargs -0 -n 1 -P 2 clang-tidy --quiet -p build/check 2> >(grep -v 'warnings generated\|warning generated\|^Suppressed\|^Use -' >&2)
fi
