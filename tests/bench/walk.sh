#!/usr/bin/env bash
# Runs the whole body's walk with every method in the release preset and writes tests/bench/walk.md.
# Usage: bash tests/bench/walk.sh [SECONDS]: cut-off of each run, default 60
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
source tests/bench/report.sh
budget=${1:-60}

measure() {
  echo "# The whole body walking"
  echo
  echo "Written by \`bash tests/bench/walk.sh $budget\`; all ratios are of one run, on one core."
  echo
  environment
  echo
  echo "## The embedded walk as it is"
  block build/release/bin/sinew bench walk --noise 0 --soft-tissue 0 --budget "$budget" \
    --methods conjugate-gradient,bfgs,lbfgs,gauss-newton,articulated
  echo
  echo "## With markers 1 mm and skin 10 mm off"
  block build/release/bin/sinew bench walk --budget "$budget"
}

write_report tests/bench/walk.md measure
