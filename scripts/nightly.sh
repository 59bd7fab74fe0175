#!/usr/bin/env bash
# What takes hours: a million inputs for every fuzz target, every test under sanitizers.
set -uo pipefail
cd "$(dirname "$0")/.."

failed=0
scripts/fuzz.sh --executions 1000000 || failed=1
scripts/sanitize.sh address all || failed=1
scripts/sanitize.sh thread all || failed=1
exit "$failed"
