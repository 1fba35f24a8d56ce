#!/usr/bin/env bash
# Measures a frame of inverse kinematics against an earlier commit, the two programs taking turns on
# one core, and writes tests/bench/speed.md.
# Usage: bash tests/bench/speed.sh [COMMIT [ROUNDS]]: default 7b5bbbc and 7
# OLD and NEW name folders of programs that are built already: frame_speed and sinew of either side.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
source tests/bench/report.sh
commit=${1:-7b5bbbc}
rounds=${2:-7}
core=$(($(nproc) - 1))
data=../shared/data

# Builds frame_speed in the tree $1 as preset release does.
build_in() {
  cmake -S "$1" --preset release >/dev/null
  cmake --build "$1/build/release" --target frame_speed sinew >/dev/null
}

if [[ -z ${NEW:-} ]]; then
  build_in .
  NEW=$PWD/build/release/bin
fi
if [[ -z ${OLD:-} ]]; then
  old=$PWD/build/speed_old
  [[ -d $old ]] || git worktree add --detach "$old" "$commit" >/dev/null
  cp tests/bench/frame_speed.cc "$old/tests/bench/"
  grep -q frame_speed "$old/tests/bench/CMakeLists.txt" ||
    grep frame_speed tests/bench/CMakeLists.txt >>"$old/tests/bench/CMakeLists.txt"
  build_in "$old"
  OLD=$old/build/release/bin
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# Each side has its own tasks for the embedded walk: what a coordinate's weight means has changed.
for side in old new; do
  programs=$NEW
  [[ $side == new ]] || programs=$OLD
  for level in simplified detailed; do
    "$programs/sinew" example --level $level --noise 0.001 --soft-tissue 0.01 \
      --out "$work/$side/$level" >/dev/null
  done
  cmp "$work/$side/simplified/walk.trc" "$work/old/simplified/walk.trc"
done
# The setup names outputs beside itself: scaled in a copy.
cp -r "$data/opensim-models/Rajagopal_run" "$work/run"
chmod -R u+w "$work/run"
"$NEW/sinew" scale --setup "$work/run/Scale/scale_setup_run.xml" \
  --model "$work/run/Rajagopal2016.osim" --out "$work/run.osim" >/dev/null 2>&1

# name|model|markers|tasks
trials() {
  local models=$data/opensim-models arnold=$data/nimblephysics/Arnold2013Synthetic
  local moco=$data/opensim-core/OpenSim/Examples/Moco/example3DWalking
  echo "Rajagopal_run|$work/run.osim|$models/Rajagopal_run/ExpData/motion_capture_run.trc|$models/Rajagopal_run/IK/ik_setup_run.xml"
  echo "BMC run|$data/BMC/data/opensim/Mod&Sim2018/Scale/Rajagopal2015_scaled.osim|$data/BMC/data/opensim/Mod&Sim2018/ExpData/motion_capture_run.trc|-"
  echo "Moco 3D walk|$moco/subject_walk_scaled.osim|$moco/markers_walk.trc|-"
  echo "Gait2354|$models/Gait2354_Simbody/subject01_simbody.osim|$models/Gait2354_Simbody/subject01_walk1.trc|$models/Gait2354_Simbody/subject01_Setup_IK.xml"
  echo "Gait10dof18musc|$models/Gait10dof18musc/subject01.osim|$models/Gait10dof18musc/ExperimentalData/subject01_walk.trc|$models/Gait10dof18musc/IK/walk_Setup_IK.xml"
  echo "Arnold2013 subject01|$arnold/subject01/subject01.osim|$arnold/subject01/trials/walk2/markers.trc|-"
  echo "Arnold2013 subject02|$arnold/subject02/subject02.osim|$arnold/subject02/trials/walk2/markers.trc|-"
  echo "walk, simplified body|SIDE/simplified/model.osim|SIDE/simplified/walk.trc|SIDE/simplified/ik_tasks.xml"
  echo "walk, detailed body|SIDE/detailed/model.osim|SIDE/detailed/walk.trc|SIDE/detailed/ik_tasks.xml"
}

# The least of what the rounds of one program took, and its last iterations and cost.
best() { sort -g -k2 "$1" | head -n 1; }
# The median over the rounds of old / new, each round's two measured one after the other.
median_ratio() {
  paste -d' ' "$1" "$2" | awk '{ print $2 / $6 }' | sort -g |
    awk '{ r[NR] = $1 } END { print r[int((NR + 1) / 2)] }'
}

measure() {
  echo "# A frame of inverse kinematics, before and now"
  echo
  echo "Written by \`bash tests/bench/speed.sh $commit $rounds\`: \`frame_speed\` built from commit"
  echo "$commit and from this tree, taking turns on one core, each round the least of its repetitions."
  echo "Times are what the process computed [µs a frame], the least over the rounds; the ratio is the"
  echo "median of the rounds' own. Both walks have markers 1 mm and skin 10 mm off."
  echo
  environment
  echo "- load while measuring: $(cut -d' ' -f1 /proc/loadavg)"
  echo
  echo "| trial | frames | before | now | ratio | iterations before | now | mean cost before | now |"
  echo "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"
  while IFS='|' read -r name model markers tasks; do
    [[ -e ${model/SIDE/$work/new} && -e ${markers/SIDE/$work/new} ]] || continue
    local repeat=10
    [[ $name == walk* ]] && repeat=1
    : >"$work/old.times"
    : >"$work/new.times"
    for ((round = 0; round < rounds; ++round)); do
      taskset -c "$core" "$OLD/frame_speed" "${model/SIDE/$work/old}" \
        "${markers/SIDE/$work/old}" "${tasks/SIDE/$work/old}" $repeat >>"$work/old.times"
      taskset -c "$core" "$NEW/frame_speed" "${model/SIDE/$work/new}" \
        "${markers/SIDE/$work/new}" "${tasks/SIDE/$work/new}" $repeat >>"$work/new.times"
    done
    read -r frames before iterations_before cost_before < <(best "$work/old.times")
    read -r frames now iterations_now cost_now < <(best "$work/new.times")
    printf '| %s | %s | %.1f | %.1f | %.2f | %s | %s | %s | %s |\n' "$name" "$frames" "$before" \
      "$now" "$(median_ratio "$work/old.times" "$work/new.times")" "$iterations_before" "$iterations_now" \
      "$cost_before" "$cost_now"
  done < <(trials)
}

measure >"$work/speed.md"
cp "$work/speed.md" tests/bench/speed.md
cat tests/bench/speed.md
