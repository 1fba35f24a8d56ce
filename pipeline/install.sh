#!/usr/bin/env bash
# Installs the Debian 12 packages that building and testing need and that are missing; does nothing
# when none is. Runs as root, or through sudo.
set -euo pipefail

packages=(
  build-essential cmake ninja-build ccache git clang-format
  clang libclang-rt-14-dev
  libsimbody-dev libeigen3-dev libsundials-dev libpugixml-dev libfmt-dev libcli11-dev
  nlohmann-json3-dev libtbb-dev libssl-dev libgtest-dev libbenchmark-dev
)

fail() {
  echo "install.sh: $*" >&2
  exit 1
}

command -v dpkg-query >/dev/null && command -v apt-get >/dev/null ||
  fail "this is no Debian-like system: dpkg-query or apt-get is missing." \
    "Install the equivalents of: ${packages[*]}; then build with cmake --preset release."

missing=()
for package in "${packages[@]}"; do
  # dpkg-query also knows removed packages; only "ok installed" can be built with.
  status=$(dpkg-query --show --showformat='${Status}' "$package" 2>/dev/null) || status=
  [[ $status == *" ok installed" ]] || missing+=("$package")
done
if [[ ${#missing[@]} == 0 ]]; then
  exit 0
fi

as_root=()
if [[ $(id -u) != 0 ]]; then
  command -v sudo >/dev/null ||
    fail "needs root to install: ${missing[*]}. Neither root nor sudo is here;" \
      "have an administrator run: apt-get install ${missing[*]}"
  as_root=(sudo)
fi
# The lock's timeout outlasts an unattended upgrade that happens to run.
apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300)

echo "Installing: ${missing[*]}"
# A package source that does not answer need not be one of ours: the install decides.
"${apt[@]}" update -q || echo "install.sh: apt-get update failed; trying the lists at hand" >&2
"${apt[@]}" install -q -y --no-install-recommends "${missing[@]}" ||
  fail "apt-get could not install: ${missing[*]}. Sinew is built for Debian 12 (bookworm);" \
    "see apt-get's message above."
