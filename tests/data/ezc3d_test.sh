#!/usr/bin/env bash
# ezc3d, in a virtual environment in the build folder, reads C3D files that sinew wrote as sinew
# itself does. Skipped where the environment cannot be made.  Usage: ezc3d_test.sh SINEW ENVIRONMENT
set -euo pipefail
sinew=$(realpath "$1")
environment=$2
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
bash "$root/tests/data/ezc3d_environment.sh" "$environment"

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
files=()
if [[ -d $root/../shared/data ]]; then
  while IFS= read -r -d '' file; do files+=("$file"); done < <(
    find "$root/../shared/data" -iname '*.c3d' -print0 | sort -z)
fi
"$environment/bin/python" "$root/tests/data/ezc3d_test.py" "$sinew" "$folder" "${files[@]}"
