#!/usr/bin/env bash
# Compares inverse kinematics of every model and recording in ../shared/data with Simbody's Assembler
# by `sinew validate`, frame by frame, and writes tests/bench/validate.md. Of the embedded walk, whose
# frames take the Assembler seconds, every fiftieth frame of the simplified body.
# Usage: bash tests/bench/validate.sh
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
source tests/bench/report.sh
source tests/bench/survey_pairs.sh

failed=0
table() {
  echo "# Inverse kinematics beside Simbody's Assembler"
  echo
  echo "Written by \`bash tests/bench/validate.sh\`: what \`sinew validate\` says, which fails where the"
  echo "cost of a frame exceeds that of the Assembler, started from the same pose, by more than 1e-6."
  echo
  environment
  echo
  echo "| pair | \`sinew validate\` |"
  echo "|---|---|"
  while IFS='|' read -r name model markers tasks from to kind; do
    [[ $kind == walk && $name != *detailed ]] || continue
    local options=(--model "$model" --markers "$markers")
    [[ -z $tasks ]] || options+=(--tasks "$tasks")
    [[ -z $from ]] || options+=(--from "$from")
    [[ -z $to ]] || options+=(--to "$to")
    [[ $name != embedded* ]] || options+=(--every 50)
    local said
    said=$("$sinew" validate "${options[@]}" 2>&1) || failed=$((failed + 1))
    echo "| $name | $(tail -n 1 <<<"$said") |"
  done <"$list"
  echo
  echo "$failed pairs failed."
}

table >"$work/report"
cp "$work/report" tests/bench/validate.md
tail -n 1 tests/bench/validate.md
