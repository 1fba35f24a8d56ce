#!/usr/bin/env bash
# Runs the whole body's walk with every method in the release preset and writes tests/bench/walk.md.
# Usage: bash tests/bench/walk.sh [SECONDS]: cut-off of each run, default 60
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
budget=${1:-60}
cmake --preset release >/dev/null
cmake --build --preset release --target sinew ik_bench
out=tests/bench/walk.md
new=$(mktemp)
trap 'rm -f "$new"' EXIT
block() { printf '\n```\n%s\n' "\$ $*"; "$@" | sed "s| *$||"; printf '```\n'; }
{
  echo "# The whole body walking"
  echo
  echo "Written by \`bash tests/bench/walk.sh $budget\`; all ratios are of one run, on one core."
  echo
  echo "- machine: $(grep -m1 'model name' /proc/cpuinfo | cut -d: -f2 | xargs), $(nproc) cores"
  echo "- compiler: $(c++ --version | head -n 1)"
  echo "- flags: -O3 -DNDEBUG, no -march=native"
  echo "- commit: $(git rev-parse --short HEAD)"
  echo
  echo "## The embedded walk as it is"
  block build/release/bin/sinew bench walk --noise 0 --soft-tissue 0 --budget "$budget" \
    --methods conjugate-gradient,bfgs,lbfgs,gauss-newton,articulated
  echo
  echo "## With markers 1 mm and skin 10 mm off"
  block build/release/bin/sinew bench walk --budget "$budget"
} 2>/dev/null > "$new"
mv "$new" "$out"
trap - EXIT
chmod 644 "$out"
echo "$out"
