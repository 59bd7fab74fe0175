#!/usr/bin/env bash
# Builds and runs every test. With arguments, those go to ctest, e.g. scripts/test.sh -L unit
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/build.sh release
ctest --test-dir build/release --no-tests=error --output-on-failure -j2 "$@"
