#!/usr/bin/env bash
# Builds base and nn with their tests for 64-bit ARM by a cross compiler and runs these tests under an
# emulator. Programs that read meshes need libraries of that machine and are built there.
#   scripts/arm64.sh [FILTER]     FILTER as for --gtest_filter
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh --arm64
cmake -S tests/arm64 -B build/arm64 -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 \
    -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++ >/dev/null
cmake --build build/arm64 ${JOBS:+-j "$JOBS"}
# Emulated, all cases would take many minutes: the kernels and what they stand on by default.
filter=${1:-*InstructionSet*:*FloatTanh*:*KernelResults*:*Parallel*:*Random*}
for test in base_test nn_test nn_speed_test; do
    qemu-aarch64 -L /usr/aarch64-linux-gnu "build/arm64/bin/$test" \
        --gtest_brief=1 --gtest_filter="$filter"
done
