#!/usr/bin/env bash
# Runs the benchmarks but the walk, which walk.sh has, with the release preset and writes tests/bench/results.md.
# Usage: bash tests/bench/make_results.sh [SECONDS [quick]]: cut-off of each run of the manipulator,
# default 60; quick shortens the tables of gradients and frames.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
source tests/bench/report.sh
budget=${1:-60}
quick=${2:-}

measure() {
  echo "# Measurements"
  echo
  echo "Written by \`bash tests/bench/make_results.sh $budget $quick\`; all ratios are of one run."
  echo
  environment
  echo
  echo "## The manipulator of Ayusawa & Nakamura 2012, beside its tables I-IV"
  for letter in A B; do
    block build/release/bin/sinew bench manipulator --case "$letter" --links 4,40,400 --budget "$budget"
  done
  block build/release/bin/sinew bench manipulator --case B --links 1200 --methods articulated-gauss-newton,articulated-newton,articulated,lbfgs --budget "$budget" --growth
  echo
  echo "## Gradients and frames"
  block build/release/bin/ik_bench $quick
}

write_report tests/bench/results.md measure
