# Sourced by the scripts that write the measurements' files.

# What was measured, and on what.
environment() {
  echo "- machine: $(grep -m1 'model name' /proc/cpuinfo | cut -d: -f2 | xargs), $(nproc) cores"
  echo "- compiler: $(c++ --version | head -n 1)"
  echo "- flags: -O3 -DNDEBUG, no -march=native"
  echo "- commit: $(git rev-parse --short HEAD)"
}

# A command and what it prints.
block() { printf '\n```\n%s\n' "\$ $*"; "$@" | sed 's/ *$//'; printf '```\n'; }

# Builds the programs, then writes what the function prints to the file, whole or not at all.
write_report() {
  local out=$1
  cmake --preset release >/dev/null
  cmake --build --preset release --target sinew ik_bench
  new=$(mktemp)
  trap 'rm -f "$new"' EXIT
  "$2" 2>/dev/null >"$new"
  mv "$new" "$out"
  trap - EXIT
  chmod 644 "$out"
  echo "$out"
}
