#!/usr/bin/env bash
# Makes a Python virtual environment with ezc3d where there is none. Exits with 77, and the reason on
# the line after "Skipped", where that cannot be done.  Usage: ezc3d_environment.sh FOLDER
set -euo pipefail
environment=$1
skip() {
  rm -rf "$environment"
  printf 'tests/data/ezc3d_environment.sh: Skipped\n%s\n' "$1"
  exit 77
}

if "$environment/bin/python" -c 'import ezc3d' 2>/dev/null; then
  exit 0
fi
rm -rf "$environment"
python3 -m venv "$environment" >/dev/null 2>&1 || skip 'needs python3-venv, to read C3D with ezc3d'
timeout 300 "$environment/bin/pip" install --quiet --disable-pip-version-check ezc3d==1.7.2 \
  >/dev/null 2>&1 || skip 'needs ezc3d from PyPI, which pip could not install'
