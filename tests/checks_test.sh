#!/usr/bin/env bash
# Tests of check_layers, check_format and check_text: each passes on a clean tree and, on a tree with
# one violation, fails and names the place.
set -euo pipefail
tests=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
failures=0

clean_tree() {
  rm -rf "$tree"
  mkdir -p "$tree"/{data,model,ik,dynamics,pipeline,tests/model,build/dev}
  cp "$tests/../.clang-format" "$tree"
  for folder in data model ik dynamics pipeline; do
    echo '#pragma once' >"$tree/$folder/own.h"
  done
  printf '#pragma once\n\n#include <Simbody.h>\n' >"$tree/model/simbody.h"
  printf '#include <CLI/CLI.hpp>\n#include <vector>\n\n#include "data/own.h"\n' \
    >"$tree/pipeline/main.cc"
  printf '#include "data/own.h"\n#include "tests/model/help.h"\n' >"$tree/tests/model/own_test.cc"
  echo '#pragma once' >"$tree/tests/model/help.h"
  echo '#include "tests/no/one.h"' >"$tree/build/dev/generated.cc"
  echo '# Title' >"$tree/README.md"
}

# passes CHECK: the tree as it stands is accepted.
passes() {
  local output
  if ! output=$("$tests/check_$1" "$tree" 2>&1); then
    failures=$((failures + 1))
    printf 'check_%s refused a clean tree:\n%s\n' "$1" "$output"
  fi
}

# refuses CHECK EXPECTED FILE CONTENT [FILE CONTENT]: the clean tree with these files is refused, and
# what is printed contains EXPECTED.
refuses() {
  local check=$1 expected=$2 file=$3 output status=0
  clean_tree
  shift 2
  while (($# > 0)); do
    mkdir -p "$(dirname "$tree/$1")"
    printf '%b' "$2" >"$tree/$1"
    shift 2
  done
  output=$("$tests/check_$check" "$tree" 2>&1) || status=$?
  if [[ $check == format && $status == 77 ]]; then
    return
  fi
  if [[ $status == 0 || $output != *"$expected"* ]]; then
    failures=$((failures + 1))
    printf 'check_%s on %s: exit %s; expected a failure with\n  %s\nfound\n%s\n' \
      "$check" "$file" "$status" "$expected" "$output"
  fi
}

once='#pragma once\n'
clean_tree
# Types of the same name that never meet.
printf '#pragma once\nnamespace sinew::trc {\nstruct Load {};\n}\n' >"$tree/data/trc.h"
printf '#pragma once\nnamespace sinew {\nstruct Load {};\n}\n' >"$tree/data/load.h"
printf 'namespace sinew {\nnamespace {\nstruct Load {};\n}  // namespace\n' >"$tree/ik/load.cc"
for check in layers text; do passes $check; done

refuses layers 'data/bad.h:3: data/ includes model/own.h; includes point left only: data <- model' \
  data/bad.h "$once\n#include \"model/own.h\"\n"
refuses layers 'ik/bad.cc:1: ik/ includes dynamics/own.h' ik/bad.cc '#include "dynamics/own.h"\n'
refuses layers 'ik/bad.cc:1: ik/ includes pipeline/own.h' ik/bad.cc ' # include <pipeline/own.h>\n'
refuses layers 'tests/model/bad_test.cc:2: model/ includes ik/own.h' \
  tests/model/bad_test.cc '\n#include "ik/own.h"\n'
refuses layers 'tests/model/bad_test.cc:1: model/ includes tests/ik/help.h' \
  tests/model/bad_test.cc '#include "tests/ik/help.h"\n'
refuses layers 'model/bad.cc:1: model/ includes tests/model/help.h; nothing but tests' \
  model/bad.cc '#include "tests/model/help.h"\n'
refuses layers 'model/bad.cc:1: "own.h" is not written from the root' \
  model/bad.cc '#include "own.h"\n'
refuses layers 'model/bad.cc:1: "model/../ik/own.h" leaves its folder' \
  model/bad.cc '#include "model/../ik/own.h"\n'
refuses layers 'data/bad.cc:1: data/ includes Simbody.h; it holds no Simbody' \
  data/bad.cc '#include <Simbody.h>\n'
refuses layers 'ik/bad.cc:1: include "model/simbody.h" instead of SimTKmath.h' \
  ik/bad.cc '#include <SimTKmath.h>\n'
refuses layers 'dynamics/bad.cc:1: dynamics/ includes CLI/CLI.hpp; only pipeline/' \
  dynamics/bad.cc '#include <CLI/CLI.hpp>\n'
refuses layers 'ik/own.h:3: Load is defined in data/bad.h:3 too' data/bad.h \
  "$once\nstruct Load {};\n" ik/own.h "$once\nenum class Load { kNone };\n"
refuses layers 'ik/bad.cc:2: sinew::Load is defined in data/bad.h:3 too' data/bad.h \
  "${once}namespace sinew {\nstruct Load final : Other {\n};\n" ik/bad.cc 'namespace sinew {\nclass Load {};\n}\n'
refuses layers 'ik/bad.h:1: has no #pragma once' ik/bad.h 'int x;\n'
refuses layers 'ik/empty.h:1: has no #pragma once' ik/empty.h ''
refuses layers 'utils/: unknown at the root' utils/bad.h "$once"
refuses layers 'notes.txt: unknown at the root' notes.txt 'x\n'
refuses layers 'tests/misc/: unknown folder' tests/misc/a_test.cc 'int x;\n'
refuses layers 'ik/bad.cpp: C++ files are named' ik/bad.cpp 'int x;\n'
refuses layers 'ik/BadName.h: file names are snake_case' ik/BadName.h "$once"
refuses layers 'tests/model/helper.cc: is not built' tests/model/helper.cc 'int x;\n'

refuses format 'ik/bad.h:3:' ik/bad.h "$once\nint  x ;\n"

# Split so that this file does not hold what it tests for.
refuses text "ik/bad.h:2:// see /wo""rk/x <- a path of one machine" ik/bad.h "$once// see /wo""rk/x\n"
refuses text 'golden/a.csv:1:"/ro' tests/golden/a.csv '"/ro''ot/a",1\n'
refuses text 'README.md:1:-I/ho' README.md '-I/ho''me/someone/include\n'
refuses text '<- a tab' ik/bad.h "$once\tint x;\n"
refuses text 'ik/bad.h:1:' ik/bad.h '#pragma once \n'
refuses text 'ik/bad.h:1:' ik/bad.h '#pragma once\r\n'

# Data files keep their tabs; a path inside a longer one or an address is no machine's.
clean_tree
mkdir "$tree/tests/golden"
printf 'time\tx\n' >"$tree/tests/golden/a.sto"
echo 'See https://example.org/work/ and build/root/x, ./work/, /jointset/hip/.' >>"$tree/README.md"
passes text

# What git ignores is not looked at.
clean_tree
printf 'build/\nignored/\n' >"$tree/.gitignore"
mkdir "$tree/ignored"
git -C "$tree" init -q
passes layers

rm -rf "$tree"
mkdir "$tree"
for check in layers format text; do
  if output=$("$tests/check_$check" "$tree" 2>&1); then
    failures=$((failures + 1))
    echo "check_$check accepted an empty tree: $output"
  fi
done

if [[ $failures != 0 ]]; then
  echo "checks_test: $failures failed"
  exit 1
fi
echo "checks_test: passed"
