#!/usr/bin/env bash
# Runs every pair of model and recording in ../shared/data that can be run, and witnesses of faults,
# with an older program and this one, and writes the verdicts of both to tests/bench/verdicts.md.
# Usage: bash tests/bench/verdicts.sh OLD_PROGRAM
# SINEW names the program of today; without it the preset `release` is built.
set -euo pipefail
old=$(realpath "${1:?give the older program: bash tests/bench/verdicts.sh OLD_PROGRAM}")
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
source tests/bench/report.sh
if [[ -z ${SINEW:-} ]]; then
  cmake --preset release >/dev/null
  cmake --build --preset release --target sinew >/dev/null
  SINEW=build/release/bin/sinew
fi
new=$(realpath "$SINEW")
data=$(realpath ../shared/data)
cases=$(realpath ../shared/cases)
mkdir -p build
work=$(realpath "$(mktemp -d -p build)")
trap 'rm -rf "$work"' EXIT

# What the older program said by its exit code.
old_words() {
  case $1 in
    0) echo "exit 0" ;;
    1) echo "failed" ;;
    2) echo "refused" ;;
    *) echo "exit $1" ;;
  esac
}

# `remarks: marker-rms 22.6 mm, ...` from a verdict.json, a field a line as it is written.
verdict_words() {
  awk '
    function value(line) {
      sub(/^[^:]*: /, "", line); sub(/,$/, "", line); gsub(/^"|"$/, "", line)
      return line
    }
    /^  "verdict":/   { level = value($0) }
    /^      "code":/   { code = value($0) }
    /^      "figure":/ { figure = value($0) }
    /^      "unit":/   {
      unit = value($0)
      text = text (text == "" ? ": " : ", ") code
      if (figure != "null") text = text sprintf(" %.3g", figure) (unit == "" ? "" : " " unit)
    }
    END { print level text }' "$1"
}

rows=0 alarms=0 missed=0
# row KIND MODEL RECORDING RIGHT ARGUMENTS...: KIND is `usable` or `unusable`, what the verdict has
# to be; @ in the arguments is a folder for the outputs.
row() {
  local kind=$1 model=$2 recording=$3 right=$4 status=0 before after file
  shift 4
  rows=$((rows + 1))
  mkdir -p "$work/$rows/old" "$work/$rows/new"
  (cd "$work" && timeout 600 "$old" "${@//@/$work/$rows/old}") >/dev/null 2>&1 || status=$?
  before=$(old_words "$status")
  status=0
  (cd "$work" && timeout 600 "$new" "${@//@/$work/$rows/new}") >/dev/null 2>&1 || status=$?
  file=$(find "$work/$rows/new" -name '*verdict.json' | head -n 1)
  after="exit $status"
  if [[ -n $file ]]; then after=$(verdict_words "$file"); fi
  if [[ $kind == usable && $after == unusable* ]]; then alarms=$((alarms + 1)); fi
  if [[ $kind == unusable && $status == 0 ]]; then missed=$((missed + 1)); fi
  printf '| %s | %s | %s | %s | %s | %s |\n' "$kind" "$model" "$recording" "$before" "$after" "$right"
}

models=$data/opensim-models core=$data/opensim-core nimble=$data/nimblephysics/Arnold2013Synthetic
bmc="$data/BMC/data/opensim/Mod&Sim2018"

# External loads for recordings that come without: both feet, columns ground_force_r_vx, ...
loads=$work/loads.xml
{
  echo '<OpenSimDocument Version="40000"><ExternalLoads name="loads"><objects>'
  for side in r l; do
    echo "<ExternalForce name=\"$side\"><applied_to_body>calcn_$side</applied_to_body>"
    echo "<force_identifier>ground_force_${side}_v</force_identifier>"
    echo "<point_identifier>ground_force_${side}_p</point_identifier>"
    echo "<torque_identifier>ground_torque_${side}_</torque_identifier></ExternalForce>"
  done
  echo '</objects></ExternalLoads></OpenSimDocument>'
} >"$loads"

published() {
  local g=$models/Gait2354_Simbody h=$models/Gait10dof18musc r=$models/Rajagopal_run
  row usable Gait2354 static 'its pose is 34 mm from the head' \
    scale --setup "$g/subject01_Setup_Scale.xml" --out-dir @
  row usable Gait2354 walk1 'as published: 22 mm, shoulders that the model lacks' \
    ik --setup "$g/subject01_Setup_IK.xml" --out @/q.mot
  row usable Gait2354 walk1 'as published' id --setup "$g/subject01_Setup_InverseDynamics.xml" \
    --coordinates "$g/reference/subject01_walk1_ik.mot" --out @/id.sto
  row usable Gait2354 walk1 'both steps are measured' run --model "$g/subject01_simbody.osim" \
    --markers "$g/subject01_walk1.trc" --tasks "$g/subject01_Setup_IK.xml" \
    --loads "$g/subject01_walk1_grf.xml" --out @
  row usable Gait10dof18musc walk 'a planar model: 30 mm' \
    ik --setup "$h/IK/walk_Setup_IK.xml" --out @/q.mot
  row usable Gait10dof18musc walk 'as published' id --setup "$h/ID/walk_Setup_ID.xml" \
    --coordinates "$h/reference/subject01_walk_IK.mot" --out @/id.sto
  row usable Gait10dof18musc walk 'both steps are measured' run --model "$h/subject01.osim" \
    --markers "$h/ExperimentalData/subject01_walk.trc" --tasks "$h/IK/walk_Setup_IK.xml" \
    --loads "$h/ExperimentalData/subject01_walk_grf.xml" --out @
  row usable subject01 'synthetic markers' 'nothing is wrong' \
    ik --setup "$core/Applications/IK/tests/resources/subject01_Setup_InverseKinematics.xml" \
    --out @/q.mot
  local i=$core/Applications/ID/tests/resources
  row usable subject01 walk1 'as published' \
    id --setup "$i/subject01_Setup_InverseDynamics.xml" --out @/id.sto
  row usable arm26 arm26 'the shoulder is bolted down: no residuals' \
    id --setup "$i/arm26_Setup_InverseDynamics.xml" --out @/id.sto
  local s=$core/Applications/Scale/tests/resources
  row usable gait2354 static 'its pose is 34 mm from the head' \
    scale --setup "$s/subject01_Setup_Scale.xml" --out-dir @
  row usable toyLigamentModel '(factors)' 'a given factor of 2' \
    scale --setup "$s/toyLigamentModel_Setup_Scale.xml" --out-dir @
  local subject a
  for subject in subject01 subject02; do
    a=$nimble/$subject
    row usable "Arnold $subject" walk2 'simulated: all is known' run --model "$a/$subject.osim" \
      --markers "$a/trials/walk2/markers.trc" --loads "$loads" \
      --load-data "$a/trials/walk2/grf.mot" --out @
    row usable "Arnold $subject" 'walk2, no forces' "angles, not the legs' torques" \
      run --model "$a/$subject.osim" --markers "$a/trials/walk2/markers.trc" --out @
    row usable "Arnold generic" "$subject walk2" 'sizes fit' \
      scale --auto --model "$nimble/unscaled_generic.osim" \
      --markers "$a/trials/walk2/markers.trc" --out @/fitted.osim
  done
  row usable 'BMC Rajagopal' run 'as published' \
    ik --setup "$bmc/IK/IK_setup.xml" --out @/q.mot
  row usable 'BMC Rajagopal' run 'flights, and steps beside the platform' \
    id --setup "$bmc/ID/id_setup.xml" --model "$bmc/Scale/Rajagopal2015_scaled.osim" \
    --coordinates "$bmc/IK/results/ik_output_run.mot" --loads "$bmc/ID/grf_setup.xml" \
    --load-data "$bmc/ExpData/grf_run.mot" --out @/id.sto
  row usable 'BMC Rajagopal' run 'the same from markers' \
    run --model "$bmc/Scale/Rajagopal2015_scaled.osim" \
    --markers "$bmc/ExpData/motion_capture_run.trc" --tasks "$bmc/IK/IK_setup.xml" \
    --loads "$bmc/ID/grf_setup.xml" --load-data "$bmc/ExpData/grf_run.mot" --out @
  row usable Rajagopal2016 'static_run' 'a pose that meets the markers' \
    scale --setup "$r/Scale/scale_setup_run.xml" --model "$r/Rajagopal2016.osim" --out-dir @
  # The run needs the model that scaling makes: today's program's.
  local scaled=$work/rajagopal
  "$new" scale --setup "$r/Scale/scale_setup_run.xml" --model "$r/Rajagopal2016.osim" \
    --out-dir "$scaled" >/dev/null 2>&1 || true
  row usable 'Rajagopal2016 scaled' run 'the forces of a treadmill: two feet' \
    run --model "$scaled/subject_scaled_run.osim" \
    --markers "$r/ExpData/motion_capture_run.trc" --tasks "$r/IK/ik_setup_run.xml" \
    --loads "$r/ID/grf_run.xml" --load-data "$r/ExpData/grf_run.mot" --out @
  local w=$core/OpenSim/Examples/Moco/example3DWalking
  row usable subject_walk_scaled 'walk' 'begins and ends beside the platforms' \
    run --model "$w/subject_walk_scaled.osim" --markers "$w/markers_walk.trc" \
    --tasks "$w/ik_tasks_walk.xml" --loads "$w/grf_walk.xml" --out @
  row usable subject_walk_scaled 'coordinates' 'as published' \
    id --model "$w/subject_walk_scaled.osim" --coordinates "$w/coordinates.sto" \
    --loads "$w/grf_walk.xml" --out @/id.sto
  local e=$models/Estimating_Joint_Reaction_Loads
  row usable subject01_adjusted walk1 'as published' \
    id --model "$e/subject01_simbody_adjusted_StaticOp.osim" \
    --coordinates "$e/subject01_walk1_Kinematics.sto" --loads "$e/foot_floor_loads.xml" \
    --out @/id.sto
  local o=$data/OpenSimRT/gait1992
  row usable gait1992 walk 'as published' \
    id --model "$o/residual_reduction_algorithm/model_adjusted.osim" \
    --coordinates "$o/residual_reduction_algorithm/task_Kinematics_q.sto" \
    --loads "$o/experimental_data/setup_grf_after_rra.xml" --out @/id.sto
  row usable whole-body 'the embedded walk' 'nothing is wrong' run --out @
}

laboratory() {
  local b=$data/BTKData r=$models/Rajagopal_run file
  row usable whole-body 'BTKData, static and walk' 'two platforms: a step of each leg' \
    run --c3d "$b/PiG_Motion-FlatFoot-Full.c3d" --static "$b/PiG_Calibration-FlatFoot-Full.c3d" \
    --model whole-body --out @
  row usable Rajagopal2016 'BTKData, static and walk' 'the same' \
    run --c3d "$b/PiG_Motion-FlatFoot-Full.c3d" --static "$b/PiG_Calibration-FlatFoot-Full.c3d" \
    --model "$r/Rajagopal2016.osim" --out @
  row usable whole-body 'BTKData, walk alone' 'the same' \
    run --c3d "$b/PiG_Motion-FlatFoot-Full.c3d" --model whole-body --out @
  row usable whole-body walking2 'two platforms' \
    run --c3d "$core/OpenSim/Tests/shared/walking2.c3d" --model whole-body --out @
  row usable whole-body test_walking 'two platforms' \
    run --c3d "$core/OpenSim/Sandbox/MatlabScripts/test_walking.c3d" --model whole-body --out @
  for file in sample_03/gait-pig sample_03/gait-pig-nz sample_04/sub_labels sample_09/PlugInC3D \
    sample_10/TYPE-3 sample_25/analogfpscale03 sample_28/type1 sample_06/MACsample; do
    row usable whole-body "c3d.org $file" 'legs and pelvis only' \
      run --c3d "$data/c3d.org/$file.c3d" --model whole-body --out @
  done
}

witnesses() {
  local r=$models/Rajagopal_run g=$models/Gait2354_Simbody c
  row unusable 'Rajagopal2016, not scaled' run 'nobody scaled the model to this person' \
    run --model "$r/Rajagopal2016.osim" --markers "$r/ExpData/motion_capture_run.trc" \
    --tasks "$r/IK/ik_setup_run.xml" --out @
  # Millimetres that the header calls centimetres.
  sed '3s/\tmm/\tcm/' "$g/subject01_walk1.trc" >"$work/cm.trc"
  row unusable Gait2354 'walk1 in a wrong unit' 'metres beside the markers' \
    run --model "$g/subject01_simbody.osim" --markers "$work/cm.trc" --out @
  c=$cases/fit-of-a-metre-without-a-word
  row unusable gm 'all markers on ground' 'a metre beside the markers' \
    ik --model "$c/gm.osim" --markers "$c/walk.trc" --out @/q.mot
  c=$cases/coordinates-nothing-measures
  row usable toy 'pelvis and trunk alone' 'the legs follow from nothing' \
    ik --model "$c/toy.osim" --markers "$c/pel.trc" --out @/q.mot
  c=$cases/loads-of-a-table-unchecked
  row usable toy 'loads as they are' 'half sines for forces' \
    run --model "$c/toy.osim" --markers "$c/walk.trc" --loads "$c/g_ok.xml" --out @
  for file in g_mm g_neg g_zup; do
    row unusable toy "loads $file" 'points in mm, forces downwards, z up' \
      run --model "$c/toy.osim" --markers "$c/walk.trc" --loads "$c/$file.xml" --out @
  done
}

measure() {
  echo "# Verdicts"
  echo
  echo "Written by \`bash tests/bench/verdicts.sh OLD_PROGRAM\`; OLD_PROGRAM is of commit" \
    "${OLD_COMMIT:-unknown} (variable OLD_COMMIT)."
  echo
  echo "The first column says what a verdict must be: \`usable\` (good or with remarks) or" \
    "\`unusable\`."
  echo
  environment
  echo
  echo "| must be | model | recording | before | now | what is right |"
  echo "|---|---|---|---|---|---|"
  published
  laboratory
  witnesses
  echo
  echo "$rows rows: $alarms false alarms (usable, called unusable), $missed missed (unusable, not" \
    "called so)."
}

table=$(mktemp)
measure >"$table"
mv "$table" tests/bench/verdicts.md
chmod 644 tests/bench/verdicts.md
tail -n 1 tests/bench/verdicts.md
