#!/usr/bin/env bash
# Tests of pipeline/install.sh, pipeline/demo.sh and tests/run.sh in a copy of the tree, with stand-ins
# for dpkg-query, apt-get, sudo, id, cmake and ctest that log how they are called.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
failures=0

mkdir -p "$tree"/{copy/pipeline,copy/tests,bin,elsewhere}
cp "$root"/pipeline/{install,demo}.sh "$tree/copy/pipeline"
cp "$root/tests/run.sh" "$tree/copy/tests"
for tool in bash env dirname grep tee rm mkdir ls awk sort nproc cat chmod; do
  ln -s "$(command -v $tool)" "$tree/bin/$tool"
done

stand_in() {
  printf '#!/usr/bin/env bash\necho "%s $*" >>"%s/calls"\n%s\n' "$1" "$tree" "$2" >"$tree/bin/$1"
  chmod +x "$tree/bin/$1"
}

# A Debian machine, root, where the packages named in $tree/missing are not installed.
fresh_machine() {
  : >"$tree/missing"
  stand_in dpkg-query "
    if grep -qx \"\${!#}\" '$tree/missing'; then echo 'no packages found' >&2; exit 1; fi
    if [[ \${!#} == ccache && -e '$tree/removed' ]]; then echo 'deinstall ok config-files'
    else echo 'install ok installed'; fi"
  stand_in apt-get ''
  stand_in id 'echo 0'
  stand_in cmake ''
  stand_in ctest ''
  rm -f "$tree/bin/sudo" "$tree/removed"
  rm -rf "$tree/copy/build" "$tree/copy/results"
}

# run SCRIPT [ARGUMENT]...: sets status, output (both streams) and calls, which leaves out queries.
run() {
  : >"$tree/calls"
  status=0
  output=$(cd "$tree/elsewhere" && PATH=$tree/bin bash "$tree/copy/$1" "${@:2}" 2>&1) || status=$?
  calls=$(grep -vE '^(dpkg-query|id) ' "$tree/calls" || true)
}

expect() {
  local what=$1
  shift
  if ! "$@"; then
    failures=$((failures + 1))
    printf '%s\n  exit %s\n  output: %s\n  calls: %s\n' "$what" "$status" "$output" "$calls"
  fi
}
has() { [[ $2 == *"$1"* ]]; }
lacks() { [[ $2 != *"$1"* ]]; }
is() { [[ $1 == "$2" ]]; }

# install.sh
fresh_machine
run pipeline/install.sh
expect 'all installed: succeeds' is 0 "$status"
expect 'all installed: calls nothing' is '' "$calls"
expect 'all installed: prints nothing' is '' "$output"

printf 'libsimbody-dev\nlibfmt-dev\n' >"$tree/missing"
run pipeline/install.sh
expect 'two missing: succeeds' is 0 "$status"
expect 'two missing: updates the lists once' has 'apt-get -o DPkg::Lock::Timeout=300 update' "$calls"
expect 'two missing: installs those two' \
  has 'install -q -y --no-install-recommends libsimbody-dev libfmt-dev' "$calls"
expect 'two missing: installs nothing else' lacks 'cmake' "$calls"

fresh_machine
touch "$tree/removed"
run pipeline/install.sh
expect 'a removed package is missing' has 'recommends ccache' "$calls"

fresh_machine
echo libfmt-dev >"$tree/missing"
stand_in apt-get '[[ $* != *update* ]]'
run pipeline/install.sh
expect 'update fails: the install decides' is 0 "$status"
stand_in apt-get '[[ $* == *update* ]]'
run pipeline/install.sh
expect 'install fails: fails' is 1 "$status"
expect 'install fails: names the packages' has 'could not install: libfmt-dev' "$output"

stand_in apt-get ''
stand_in id 'echo 1000'
run pipeline/install.sh
expect 'no root, no sudo: fails' is 1 "$status"
expect 'no root, no sudo: says so' has 'Neither root nor sudo' "$output"
expect 'no root, no sudo: calls nothing' is '' "$calls"
stand_in sudo '"$@"'
run pipeline/install.sh
expect 'sudo: succeeds' is 0 "$status"
expect 'sudo: installs through it' has 'sudo env DEBIAN_FRONTEND=noninteractive apt-get' "$calls"
: >"$tree/missing"
run pipeline/install.sh
expect 'no root, all installed: succeeds' is 0 "$status"

rm "$tree/bin/apt-get"
run pipeline/install.sh
expect 'not Debian: fails' is 1 "$status"
expect 'not Debian: says so' has 'no Debian-like system' "$output"

# demo.sh
fresh_machine
stand_in cmake "if [[ \$1 == --build ]]; then
    mkdir -p build/release/bin
    printf '#!/usr/bin/env bash\nmkdir -p \$3 && echo \"sinew \$*\" >\$3/q' >build/release/bin/sinew
    chmod +x build/release/bin/sinew
  fi"
run pipeline/demo.sh
expect 'demo: succeeds' is 0 "$status"
expect 'demo: builds the command only' has 'cmake --build --preset release --target sinew' "$calls"
expect 'demo: runs the walk' is 'sinew run --out results/demo' \
  "$(cat "$tree/copy/results/demo/q" 2>/dev/null)"
expect 'demo: says where the results are' has "Results in $tree/copy/results/demo" "$output"
stand_in cmake '[[ $1 != --build ]]'
run pipeline/demo.sh
expect 'demo: stops where the build fails' is 1 "$status"

# run.sh. ctest_that XML TEXT STATUS: what ctest writes, prints and returns.
ctest_that() {
  stand_in ctest "printf '$1' >build/\$2/tests.xml; printf '$2'; exit $3"
}
fresh_machine
stand_in cmake 'mkdir -p build/dev build/check'
ran='<testcase name="a" status="run">\n</testcase>\n'
skipped='<testcase name="b" status="notrun">\n<skipped message="x"/>\n'
skipped+='<system-out>f.cc:1: Skipped\nneeds a &lt;b&gt; &amp; c\n</system-out>\n</testcase>\n'
ctest_that "$ran$skipped$skipped" '100%% tests passed, 0 tests failed out of 3\n' 0
run tests/run.sh
expect 'tests: succeeds' is 0 "$status"
expect 'tests: preset dev' has 'ctest --preset dev' "$calls"
expect 'tests: counts the skipped' has '1 tests ran, 2 were skipped:
  2: needs a <b> & c
100% tests passed, 0 tests failed out of 3' "$output"
run tests/run.sh check
expect 'tests: takes a preset' has 'cmake --build --preset check' "$calls"
expect 'tests: takes a preset' has 'ctest --preset check' "$calls"

ctest_that "$ran" '50%% tests passed, 1 tests failed out of 2\n' 8
run tests/run.sh
expect 'tests: fails as ctest does' is 8 "$status"
ctest_that "$skipped" '100%% tests passed, 0 tests failed out of 1\n' 0
run tests/run.sh
expect 'tests: all skipped is a failure' is 1 "$status"
expect 'tests: all skipped is a failure' has 'no test ran in preset dev' "$output"
stand_in ctest 'echo "No tests were found!!!"; exit 8'
run tests/run.sh
expect 'tests: none found is a failure' has 'no test ran in preset dev' "$output"
stand_in cmake '[[ $1 != --build ]]'
run tests/run.sh
expect 'tests: a failed build is a failure' is 1 "$status"
expect 'tests: nothing is tested after a failed build' lacks ctest "$calls"

if [[ $failures != 0 ]]; then
  echo "setup_scripts_test: $failures failed"
  exit 1
fi
echo "setup_scripts_test: passed"
