#!/usr/bin/env bash
# Starts frames of every model and recording in ../shared/data, static trials and the embedded walk
# included, from the default pose and from seeded random ones by every method and by the search
# that cold frames get, and writes how often each ends at the lowest cost that any found.
# Usage: bash tests/bench/survey.sh [STARTS] [FRAMES]     (default: 16 5) → tests/bench/survey.md
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
starts=${1:-16} frames=${2:-5}
source tests/bench/survey_pairs.sh
cmake --build --preset release --target survey

report=tests/bench/survey.md
{
  cat <<TEXT
# Minima from the default pose and from $starts random ones

Written by \`tests/bench/survey.sh\`. A cell says in how many of the frames the method ends at the
lowest cost from the default pose, and from how many of the random poses; the lowest is that of all
methods, starts and searches, and is met within 1e-6 of it. \`search\` is what frames get that start
cold. A pair is given a minute, after which no further frame is begun. Poses in which a joint that functions follow has turned by more than half a turn do not count.

TEXT
  build/release/bin/survey "$list" "$starts" "$frames"
} >"$work/report"
mv "$work/report" "$report"
echo "$report"
