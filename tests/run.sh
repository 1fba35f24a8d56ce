#!/usr/bin/env bash
# Installs what is missing, then configures, builds and tests one preset.
# Usage: bash tests/run.sh [dev|check|release]     (default: dev)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
preset=${1:-dev}

# Reads ctest's JUnit file and prints how many tests were skipped and why, one line a reason; fails
# if none ran. GoogleTest and our shell tests write the reason after a line that ends in ": Skipped".
report_skipped() {
  awk '
    function decoded(text) {
      gsub(/&lt;/, "<", text); gsub(/&gt;/, ">", text); gsub(/&quot;/, "\"", text)
      gsub(/&amp;/, "\\&", text)
      return text
    }
    /<testcase /   { skipped = 0; wanted = 0; reason = "no reason given" }
    /<testcase .*status="(run|fail)"/ { ran++ }
    /<skipped /    { skipped = 1 }
    wanted         { if ($0 !~ /^(\[|<\/system-out>|$)/) reason = decoded($0); wanted = 0 }
    /: Skipped$/   { wanted = 1 }
    /<\/testcase>/ { if (skipped) { total++; count[reason]++ } }
    END {
      printf "%d tests ran, %d were skipped%s\n", ran, total, total ? ":" : ""
      for (reason in count) printf "  %d: %s\n", count[reason], reason | "sort -k1,1nr"
      close("sort -k1,1nr")
      exit ran == 0
    }' "$1"
}

bash pipeline/install.sh

cmake --preset "$preset"
cmake --build --preset "$preset" -j "$(nproc)"

results=build/$preset/tests
rm -f "$results.xml"
status=0
ctest --preset "$preset" -j "$(nproc)" --no-tests=error --output-junit tests.xml 2>&1 |
  tee "$results.log" || status=$?

echo
if ! [[ -f $results.xml ]] || ! report_skipped "$results.xml"; then
  echo "tests/run.sh: no test ran in preset $preset" >&2
  exit 1
fi
grep -E '^[0-9]+% tests passed' "$results.log"
exit "$status"
