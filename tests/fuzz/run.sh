#!/usr/bin/env bash
# Builds the fuzzers with the preset `fuzz` and runs them, one after the other: readers of C3D, TRC,
# MOT and STO, and models, under ASan and UBSan, each input within 10 s and within the memory that
# tests/fuzz/reading.h allows. They start from ../shared/data, where that is there, and from files
# of our own writers. Fails with the input that does harm in build/fuzz/findings.
# Usage: bash tests/fuzz/run.sh [SECONDS [TARGET...]]: in all, default 60; c3d, trc, storage, osim.
# FUZZ_CORPUS=FOLDER keeps what was found interesting, for the next run.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
seconds=${1:-60}
targets=("${@:2}")
[[ ${#targets[@]} != 0 ]] || targets=(c3d trc storage osim)
[[ $seconds =~ ^[1-9][0-9]*$ ]] || { echo "fuzz: $seconds is no number of seconds" >&2; exit 2; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
echo 'extern "C" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }' \
  >"$work/probe.cc"
if ! clang++ -fsanitize=fuzzer,address "$work/probe.cc" -o "$work/probe" 2>/dev/null; then
  printf 'tests/fuzz/run.sh: Skipped\nneeds clang++ with libFuzzer; pipeline/install.sh has it\n'
  exit 77
fi

cmake --preset fuzz >"$work/configure.log" || { cat "$work/configure.log"; exit 1; }
cmake --build --preset fuzz -j "$(nproc)" >"$work/build.log" || { cat "$work/build.log"; exit 1; }
build/fuzz/bin/make_seeds "$work/seeds"
mkdir -p build/fuzz/findings

max_bytes() { case $1 in osim) echo 65536 ;; *) echo 16384 ;; esac }

# Real files, cut to what the fuzzer takes: recordings anywhere, tables behind a row. A cut model is
# no model, so only small ones count.
add_real_files() {
  local target=$1 limit file number=0
  limit=$(max_bytes "$target")
  local -A endings=([c3d]=c3d [trc]=trc [storage]='sto|mot' [osim]=osim)
  [[ -d ../shared/data ]] || return 0
  while IFS= read -r -d '' file; do
    number=$((number + 1))
    case $target in
      c3d) head -c "$limit" "$file" >"$work/seeds/$target/real_$number" ;;
      osim) [[ $(stat -c %s "$file") -gt $limit ]] || cp "$file" "$work/seeds/$target/real_$number" ;;
      *) head -c "$limit" "$file" | sed '$d' >"$work/seeds/$target/real_$number" ;;
    esac
  done < <(find ../shared/data -regextype egrep -iregex ".*\.(${endings[$target]})" -print0)
}

status=0
share=$((seconds / ${#targets[@]}))
[[ $share -gt 0 ]] || share=1
for target in "${targets[@]}"; do
  [[ -x build/fuzz/bin/${target}_fuzz ]] || { echo "fuzz: there is no target $target" >&2; exit 2; }
  add_real_files "$target"
  corpus=${FUZZ_CORPUS:-$work/corpus}/$target
  log=build/fuzz/$target.log
  mkdir -p "$corpus"
  chmod -R u+w "$work/seeds"
  # The hooks of reading.h bound all memory together; these two bound what is outside of them.
  if ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1 \
    UBSAN_OPTIONS=print_stacktrace=1 \
    build/fuzz/bin/"${target}_fuzz" -max_total_time="$share" -max_len="$(max_bytes "$target")" \
    -timeout=10 -rss_limit_mb=1024 -malloc_limit_mb=256 -print_final_stats=1 \
    -dict="tests/fuzz/$target.dict" -artifact_prefix="build/fuzz/findings/$target-" \
    "$corpus" "$work/seeds/$target" >"$log" 2>&1; then
    runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
    echo "fuzz: $target, $(find "$work/seeds/$target" -type f | wc -l) seeds, $runs inputs in" \
      "$share s: no finding ($(grep -oE 'cov: [0-9]+ ft: [0-9]+' "$log" | tail -n 1))"
  else
    status=1
    echo "fuzz: $target has a finding; all of it is in $log"
    grep -nE -A 25 'ERROR: |runtime error|does not hold|are allowed' "$log" | head -n 60 || true
    grep -E 'Test unit written to' "$log" || tail -n 20 "$log"
  fi
done
exit "$status"
