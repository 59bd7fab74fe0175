#!/usr/bin/env bash
# Builds tests with sanitizers and runs them.
#   scripts/sanitize.sh address [quick|all]   addresses and undefined behaviour, by clang
#   scripts/sanitize.sh thread [quick|all]    threads: loops, training, the engine
# quick, unless named: the tests of what reads, or of what runs in threads; all: every test.
set -euo pipefail
cd "$(dirname "$0")/.."

kind=${1:-} extent=${2:-quick}
if [[ ! $kind =~ ^(address|thread)$ || ! $extent =~ ^(quick|all)$ ]]; then
    sed -n '3,4s/^#   //p' "$0" >&2
    exit 2
fi

# Those that measure time or memory measure the sanitizer.
never='^(nn_speed_test|nn_allocation_test|nn_instruction_sets_test|mscomp_memory_test|acapfeat_streaming_test|library_calls_test|docs_test|command_pages_test)/'
if [[ $kind == address ]]; then
    preset=asan
    targets=(base_test mesh_test acap_test check_test config_test convert_test cli_test
             fuzz_replay_test acapfeat_cli_test acapfeat_check_cli_test acapfeat_convert_cli_test
             acapfeat_generate_cli_test acapfeat_reconstruct_cli_test mscomp_cli_test
             mscomp_positions_cli_test mscomp_synthesize_cli_test)
else
    preset=tsan
    targets=(base_test linear_test nn_test run_test)
    # One thread each, and long: the table of gradients, equations worked out by hand, files.
    [[ $extent == all ]] || never+='|^nn_test/.*(EveryOp|FusedAutoencoder|Decoding|ModelFileTest)'
fi

build=build/$preset
cmake --preset "$preset" >/dev/null
if [[ $extent == all ]]; then
    cmake --build "$build" ${JOBS:+-j "$JOBS"} >&2
    only=()
else
    cmake --build "$build" ${JOBS:+-j "$JOBS"} --target "${targets[@]}" >&2
    only=(-R "^($(IFS='|'; echo "${targets[*]}"))/" -LE slow)
fi
export UBSAN_OPTIONS=print_stacktrace=1
# libraries that are not built so seem to race at their barriers
export TSAN_OPTIONS=ignore_noninstrumented_modules=1
export LSAN_OPTIONS=suppressions=$PWD/tests/leaks.supp:print_suppressions=0
ctest --test-dir "$build" --no-tests=error --output-on-failure -j2 "${only[@]}" -E "$never"
