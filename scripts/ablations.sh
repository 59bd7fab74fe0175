#!/usr/bin/env bash
# All ablations of data/ablations on one feature file, one folder each, and their tables in one page:
#   scripts/ablations.sh FEATURES [OUTPUT] [OPTION of mscomp sweep]...
# e.g. scripts/ablations.sh horse.safetensors ablations --set 'data.split={train: every, step: 10}'
# Interrupted, it goes on where it was with the same command.
set -euo pipefail

[ $# -ge 1 ] || { sed -n '2,5s/^# //p' "$0"; exit 2; }
root=$(cd "$(dirname "$0")/.." && pwd)
bin=${MSCOMP_BIN:-$root/build/release/bin}
features=$1
output=${2:-ablations}
shift $(($# > 1 ? 2 : 1))

mkdir -p "$output"
failed=0
for sweep in "$root"/data/ablations/*.yaml; do
    name=$(basename "$sweep" .yaml)
    printf '\n== %s\n' "$name" >&2
    code=0
    "$bin/mscomp" sweep "$sweep" -o "$output/$name" --set "data.features=$features" "$@" >/dev/null ||
        code=$?
    # 5: a point failed, and its row says so. Anything else stops everything.
    case $code in 0) ;; 5) failed=5 ;; *) exit "$code" ;; esac
done

for sweep in "$root"/data/ablations/*.yaml; do
    name=$(basename "$sweep" .yaml)
    printf '## %s\n\n' "$name"
    sed -n 's/^# //p' "$sweep"
    printf '\n'
    cat "$output/$name/table.md"
    printf '\n'
done >"$output/tables.md"
printf '%s/tables.md\n' "$output"
exit $failed
