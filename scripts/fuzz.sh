#!/usr/bin/env bash
# Builds the fuzz targets and runs each, two at a time, under ASan and UBSan. Needs clang; see
# docs/testing.md.
#   scripts/fuzz.sh [SECONDS [TARGET...]]             600 seconds and all targets unless named
#   scripts/fuzz.sh --executions COUNT [TARGET...]    so many inputs each, however long it takes
# Starts from tests/fuzz/corpus. What is new goes to build/asan/corpus, what fails and the logs to
# build/asan/findings; the exit code is 1 if anything failed. MSCOMP_FUZZ_SEED makes two runs alike.
#   scripts/fuzz.sh --merge [TARGET...]       adds the new inputs that reach new code to tests/fuzz
set -euo pipefail
cd "$(dirname "$0")/.."

usage() { sed -n '4,5s/^#   //p;8s/^#   //p' "$0" >&2; exit 2; }
merge=false
limit=-max_total_time=600
case ${1:-} in
    --merge) merge=true; shift ;;
    --executions)
        [[ ${2:-} =~ ^[0-9]+$ ]] || usage
        limit=-runs=$2
        shift 2
        ;;
    "") ;;
    *)
        [[ $1 =~ ^[0-9]+$ ]] || usage
        limit=-max_total_time=$1
        shift
        ;;
esac

build=${MSCOMP_FUZZ_BUILD:-build/asan}
cmake --preset asan -B "$build" >/dev/null
cmake --build "$build" ${JOBS:+-j "$JOBS"} --target fuzz >&2
targets=("$@")
if ((${#targets[@]} == 0)); then
    mapfile -t targets < <(cd "$build/bin" && printf '%s\n' fuzz_* | sed -n 's/^fuzz_//p' |
        grep -v '^replay_test$')
fi

# The targets write and read small files again and again: in memory where there is such a folder.
memory=${TMPDIR:-/tmp}
[[ -w /dev/shm ]] && memory=/dev/shm
TMPDIR=$(mktemp -d "$memory/mscomp-fuzz-XXXXXX")
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT
findings=$build/findings
mkdir -p "$findings"

# A model has more parts than fit into what is enough for the others.
longest() { case $1 in model) echo 16384 ;; npz) echo 8192 ;; *) echo 4096 ;; esac; }

fuzz() {  # TARGET
    mkdir -p "$build/corpus/$1" "tests/fuzz/corpus/$1"
    nice "$build/bin/fuzz_$1" "$limit" -max_len="$(longest "$1")" -timeout=60 \
        -malloc_limit_mb=64 -rss_limit_mb=1024 -print_final_stats=1 \
        -seed="${MSCOMP_FUZZ_SEED:-0}" \
        -dict="tests/fuzz/dictionaries/$1.dict" -artifact_prefix="$findings/$1-" \
        "$build/corpus/$1" "tests/fuzz/corpus/$1" >"$findings/$1.log" 2>&1
}

merge() {  # TARGET
    mkdir -p "$build/corpus/$1" "$TMPDIR/$1"
    "$build/bin/fuzz_$1" -merge=1 -use_counters=0 -use_value_profile=0 \
        -max_len=$(($(longest "$1") - 1)) "$TMPDIR/$1" \
        "tests/fuzz/corpus/$1" "$build/corpus/$1" >"$findings/$1-merge.log" 2>&1
    rm -rf "tests/fuzz/corpus/$1"
    cp -r "$TMPDIR/$1" "tests/fuzz/corpus/$1"
    echo "fuzz: $1: $(find "tests/fuzz/corpus/$1" -type f | wc -l) inputs"
}

if $merge; then
    for target in "${targets[@]}"; do merge "$target"; done
    exit 0
fi

failed=0
for ((i = 0; i < ${#targets[@]}; i += 2)); do
    pids=()
    for target in "${targets[@]:i:2}"; do
        fuzz "$target" &
        pids+=($!)
    done
    for ((k = 0; k < ${#pids[@]}; ++k)); do
        target=${targets[i + k]}
        result=clean
        wait "${pids[k]}" || { result="FAILED, see $findings/$target.log"; failed=1; }
        runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$findings/$target.log")
        echo "fuzz: $target: ${runs:-?} runs, $result"
    done
done
exit "$failed"
