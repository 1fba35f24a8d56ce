#!/usr/bin/env bash
# Runs all benchmarks with the release preset and writes tests/bench/results.md.
# Usage: bash tests/bench/make_results.sh [SECONDS [quick]]: cut-off of each run of the manipulator,
# default 60; quick shortens the tables of gradients and frames.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
budget=${1:-60}
quick=${2:-}
cmake --preset release >/dev/null
cmake --build --preset release --target sinew ik_bench
out=tests/bench/results.md
new=$(mktemp)
trap 'rm -f "$new"' EXIT
block() { printf '\n```\n%s\n' "\$ $*"; "$@"; printf '```\n'; }
{
  echo "# Measurements"
  echo
  echo "Written by \`bash tests/bench/make_results.sh $budget $quick\`; all ratios are of one run."
  echo
  echo "- machine: $(grep -m1 'model name' /proc/cpuinfo | cut -d: -f2 | xargs), $(nproc) cores"
  echo "- compiler: $(c++ --version | head -n 1)"
  echo "- flags: -O3 -DNDEBUG, no -march=native"
  echo "- commit: $(git rev-parse --short HEAD)"
  echo
  echo "## The manipulator of Ayusawa & Nakamura 2012, beside its tables I-IV"
  for letter in A B; do
    block build/release/bin/sinew bench manipulator --case "$letter" --links 4,40,400 --budget "$budget"
  done
  block build/release/bin/sinew bench manipulator --case B --links 1200 --methods articulated-gauss-newton,articulated-newton,articulated,lbfgs --budget "$budget" --growth
  echo
  echo "## Gradients and frames"
  block build/release/bin/ik_bench $quick
} 2>/dev/null > "$new"
mv "$new" "$out"
trap - EXIT
chmod 644 "$out"
echo "$out"
