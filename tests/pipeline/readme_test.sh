#!/usr/bin/env bash
# Runs README.md's examples: every bash block that starts with the command, in order, in one empty
# folder. Fails where an example fails, where a subcommand has no example, and where another block
# names a script or a preset that does not exist.  Usage: readme_test.sh README SINEW
set -euo pipefail
readme=$(realpath "$1")
sinew=$(realpath "$2")
root=$(dirname "$readme")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir -p "$folder"/{blocks,bin,work/build/release/bin}
ln -s "$sinew" "$folder/bin/sinew"
ln -s "$sinew" "$folder/work/build/release/bin/sinew"

# One file a bash block, named by the line on which it starts.
awk -v to="$folder/blocks" '
  /^```bash$/ { name = sprintf("%s/%05d", to, NR); next }
  /^```/      { name = ""; next }
  name != ""  { print > name }' "$readme"

failures=0
fail() {
  failures=$((failures + 1))
  echo "README.md:$line: $*"
}

examples=0
: >"$folder/examples"
shopt -s nullglob
for block in "$folder"/blocks/*; do
  line=$((10#$(basename "$block")))
  if head -n 1 "$block" | grep -qE '^(build/release/bin/)?sinew( |$)'; then
    examples=$((examples + 1))
    cat "$block" >>"$folder/examples"
    if ! (cd "$folder/work" && PATH=$folder/bin:$PATH bash -euo pipefail "$block") \
      >"$folder/output" 2>&1 </dev/null; then
      fail "fails:"
      cat "$block" "$folder/output"
    fi
    continue
  fi
  for script in $(sed -nE 's/^bash ([^ ]+).*/\1/p' "$block"); do
    [[ -f $root/$script ]] || fail "there is no $script"
  done
  for preset in $(grep -oE -- '--preset [a-z]+' "$block" | sed 's/.* //'); do
    grep -q "\"name\": \"$preset\"" "$root/CMakePresets.json" || fail "there is no preset $preset"
  done
done

line=1
subcommands=$("$sinew" --help | awk '
  /^Subcommands:/    { listed = 1; next }
  /^[^ ]/ || !NF     { listed = 0 }
  listed && /^  [a-z]/ { print $1 }')
[[ -n $subcommands ]] || fail "sinew --help lists no subcommands"
for subcommand in $subcommands; do
  grep -qE "sinew $subcommand( |\$)" "$folder/examples" || fail "no example of sinew $subcommand"
done

if [[ $failures != 0 ]]; then
  echo "readme_test: $failures failed"
  exit 1
fi
echo "readme_test: $examples blocks of examples ran"
