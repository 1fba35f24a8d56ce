#!/usr/bin/env bash
# Turns a C3D file of a gigabyte into a TRC file and has ezc3d read the same file, one after the
# other, and writes what both took to tests/bench/c3d_large.md. ezc3d takes ten times the file's size
# in memory.  Usage: bash tests/bench/c3d_large.sh [BYTES]: of the file, default 1000000000.
# SINEW names the program to measure; without it the preset `release` is built.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
bytes=${1:-1000000000}
if [[ -z ${SINEW:-} ]]; then
  cmake --preset release >/dev/null
  cmake --build --preset release --target sinew >/dev/null
  SINEW=build/release/bin/sinew
fi
bash tests/data/ezc3d_environment.sh build/ezc3d_environment
python=$PWD/build/ezc3d_environment/bin/python
folder=$(mktemp -d -p build)
trap 'rm -rf "$folder"' EXIT
"$python" tests/bench/c3d_large.py write "$folder/large.c3d" "$bytes"
table=$("$python" tests/bench/c3d_large.py compare "$(realpath "$SINEW")" "$folder/large.c3d" \
  "$folder/large.trc")
{
  echo "# Reading a large C3D file"
  echo
  echo "Written by \`bash tests/bench/c3d_large.sh $bytes\`; ratios are of one run, ezc3d to sinew."
  echo "sinew reads, and writes $(($(stat -c %s "$folder/large.trc") / 1000000)) MB of text; ezc3d" \
    "reads into memory, from Python. On a busy machine only the processor's seconds count."
  echo
  echo "- machine: $(grep -m1 'model name' /proc/cpuinfo | cut -d: -f2 | xargs), $(nproc) cores," \
    "load $(cut -d' ' -f1 /proc/loadavg)"
  echo "- $(realpath --relative-to=. "$SINEW"), ezc3d $("$python" -c 'from importlib.metadata import version; print(version("ezc3d"))')"
  echo
  echo "$table"
} >tests/bench/c3d_large.md
cat tests/bench/c3d_large.md
