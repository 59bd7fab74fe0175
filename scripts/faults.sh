#!/usr/bin/env bash
# Makes calls of the system fail in every command that writes (docs/testing.md), and prints how many
# were tried: the lines of the table there.
#   scripts/faults.sh [TRIES [FILTER]]   at most TRIES of the calls of each class and kind of fault, all
#                                        unless given; FILTER names commands: '*Train*'
# Commands that take long are also killed 1,000 times at moments that are no call's, TRIES times each
# if that is less. Commands are tried side by side, JOBS at a time (all processors).
set -euo pipefail
cd "$(dirname "$0")/.."

export MSCOMP_FAULT_TRIES=${1:-1000000}
export MSCOMP_FAULT_KILLS=$((MSCOMP_FAULT_TRIES < 112 ? MSCOMP_FAULT_TRIES : 112))
cmake --preset release >/dev/null
cmake --build --preset release --target faults_test >&2
# Everything is written and synced thousands of times: in memory where there is such a folder.
[[ -w /dev/shm ]] && export TMPDIR=/dev/shm

export GTEST_TOTAL_SHARDS=${JOBS:-$(nproc)}
said=$(mktemp -d)
trap 'rm -rf "$said"' EXIT
for ((i = 0; i < GTEST_TOTAL_SHARDS; ++i)); do
    GTEST_SHARD_INDEX=$i build/release/bin/faults_test --gtest_brief=1 --gtest_filter="*${2:-*}*" \
        >"$said/$i" 2>&1 &
    parts[i]=$!
done
failed=0
for ((i = 0; i < GTEST_TOTAL_SHARDS; ++i)); do
    wait "${parts[i]}" || failed=1
    cat "$said/$i"
done
exit $failed
