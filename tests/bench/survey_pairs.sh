# To be sourced in the project's root: builds the program, $sinew, and lists every model and recording
# in ../shared/data that inverse kinematics can be solved for, static trials and the embedded walk with
# noise included: $list has a line a pair, as survey.cc reads it. $work is a folder that goes with the
# script.

data=$PWD/../shared/data
[[ -d $data ]] || { echo "$0: no recordings: $data is missing" >&2; exit 1; }
cmake --preset release >/dev/null
cmake --build --preset release --target sinew >/dev/null
sinew=$PWD/build/release/bin/sinew
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
list=$work/list
models=$data/opensim-models arnold=$data/nimblephysics/Arnold2013Synthetic
core=$data/opensim-core/Applications bmc="$data/BMC/data/opensim/Mod&Sim2018"
rajagopal=$models/Rajagopal_run/Rajagopal2016.osim

# name model markers tasks from to kind
pair() { (IFS='|'; echo "$*") >>"$list"; }

# A ScaleTool setup's scaled model before markers are placed, and after.
scaled() { # folder model options…
  local folder=$work/$1 model=$2
  shift 2
  "$sinew" scale --model "$model" "$@" --out-dir "$folder" >/dev/null 2>&1 || true
}

# Everything that `sinew run` made of a laboratory's trial.
laboratory() { # name c3d static
  local folder=$work/$1 name=$1
  "$sinew" run --c3d "$2" ${3:+--static "$3"} --model "$rajagopal" --out "$folder" \
    >/dev/null 2>&1 || true
  [[ -f $folder/ik_tasks.xml ]] || { echo "$0: $name could not be run" >&2; return; }
  pair "$name, walk" "$folder/model.osim" "$folder/markers.trc" "$folder/ik_tasks.xml" "" "" walk
  [[ -z ${3:-} ]] || pair "$name, static" "$folder/model.osim" "$folder/static.trc" "" "" "" static
}

static_pair() { # name setup model set static
  local folder=$work/$1 only=$work/$1/scaled.osim
  mkdir -p "$folder"
  "$sinew" scale --setup "$2" --model "$3" ${4:+--marker-set "$4"} --keep-markers \
    --out-dir "$folder" --out "$only" >/dev/null 2>&1 || true
  [[ -f $only ]] || { echo "$0: $1 could not be scaled" >&2; return; }
  pair "$1, static" "$only" "$5" "$2" "" "" static
}

static_pair Rajagopal_run "$models/Rajagopal_run/Scale/scale_setup_run.xml" "$rajagopal" "" \
  "$models/Rajagopal_run/ExpData/static_run.trc"
static_pair Gait2354 "$models/Gait2354_Simbody/subject01_Setup_Scale.xml" \
  "$models/Gait2354_Simbody/gait2354_simbody.osim" \
  "$models/Gait2354_Simbody/gait2354_Scale_MarkerSet.xml" \
  "$models/Gait2354_Simbody/subject01_static.trc"
static_pair Scale-test "$core/Scale/tests/resources/subject01_Setup_Scale.xml" \
  "$core/Scale/tests/resources/gait2354_simbody.osim" \
  "$core/Scale/tests/resources/gait2354_Scale_MarkerSet.xml" \
  "$core/Scale/tests/resources/subject01_static.trc"
scaled run "$rajagopal" --setup "$models/Rajagopal_run/Scale/scale_setup_run.xml"
pair "Rajagopal_run, run" "$work/run/subject_scaled_run.osim" \
  "$models/Rajagopal_run/ExpData/motion_capture_run.trc" \
  "$models/Rajagopal_run/IK/ik_setup_run.xml" "" "" walk
pair "Gait2354, walk" "$models/Gait2354_Simbody/subject01_simbody.osim" \
  "$models/Gait2354_Simbody/subject01_walk1.trc" \
  "$models/Gait2354_Simbody/subject01_Setup_IK.xml" 0.4 1.6 walk
pair "IK-test, walk" "$core/IK/tests/resources/subject01_simbody.osim" \
  "$core/IK/tests/resources/subject01_synthetic_marker_data.trc" \
  "$core/IK/tests/resources/gait2354_IK_Tasks_uniform.xml" "" "" walk
gait10=$models/Gait10dof18musc
pair "Gait10dof18musc, walk" "$gait10/subject01.osim" \
  "$gait10/ExperimentalData/subject01_walk.trc" "$gait10/IK/walk_Setup_IK.xml" "" "" walk
pair "Gait10dof18musc, static" "$gait10/subject01.osim" \
  "$gait10/ExperimentalData/subject01_static.trc" "" "" "" static
for subject in subject01 subject02; do
  pair "Arnold2013 $subject, walk" "$arnold/$subject/$subject.osim" \
    "$arnold/$subject/trials/walk2/markers.trc" "" "" "" walk
  pair "Arnold2013 unscaled on $subject" "$arnold/unscaled_generic.osim" \
    "$arnold/$subject/trials/walk2/markers.trc" "" "" "" walk
done
pair "BMC, run" "$bmc/Scale/Rajagopal2015_scaled.osim" "$bmc/ExpData/motion_capture_run.trc" \
  "$bmc/IK/IK_setup.xml" "" "" walk
laboratory BTKData "$data/BTKData/PiG_Motion-FlatFoot-Full.c3d" \
  "$data/BTKData/PiG_Calibration-FlatFoot-Full.c3d"
laboratory sample_09 "$data/c3d.org/sample_09/PlugInC3D.c3d"
laboratory sample_01 "$data/c3d.org/sample_01/Eb015pi.c3d"
for level in simplified detailed; do
  "$sinew" example --level $level --noise 0.001 --soft-tissue 0.01 --out "$work/$level" >/dev/null
  pair "embedded walk, $level" "$work/$level/model.osim" "$work/$level/walk.trc" \
    "$work/$level/ik_tasks.xml" "" "" walk
done
