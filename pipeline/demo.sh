#!/usr/bin/env bash
# From a fresh clone to joint torques: installs what is missing, builds the release preset and runs
# the walk that is embedded in the command. Usage: bash pipeline/demo.sh
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

echo "[1/4] Packages"
bash pipeline/install.sh
echo "[2/4] Configuring build/release"
cmake --preset release
echo "[3/4] Building build/release/bin/sinew"
cmake --build --preset release --target sinew
echo "[4/4] Running the embedded walk"
build/release/bin/sinew run --out results/demo

echo
echo "Results in $PWD/results/demo:"
ls -l results/demo
