// Small inputs for the fuzzers to start from, by the project's own writers.
// Usage: make_seeds FOLDER; files go into FOLDER/c3d, trc, storage and osim.

#include <cstdio>
#include <filesystem>

#include "data/c3d_writer.h"
#include "data/output_file.h"
#include "data/storage_file.h"
#include "data/trc_file.h"
#include "model/osim_writer.h"

using namespace sinew;

namespace {

namespace fs = std::filesystem;

MarkerTrajectories markers() {
  MarkerTrajectories result;
  result.names = {"LASI", "RASI", "V.Sacral"};
  result.rate = 100.0;
  result.p_WM.resize(6, 9);
  result.time.resize(6);
  for (int i = 0; i < 6; ++i) {
    result.frame_numbers.push_back(i + 1);
    result.time[i] = i / result.rate;
    for (int k = 0; k < 9; ++k) result.p_WM(i, k) = 0.25 * k + 0.0625 * i + 0.5;
  }
  result.p_WM.row(2).segment<3>(3).setConstant(std::nan(""));
  return result;
}

// Six channels on a platform of `type`, three samples a frame, a computed angle, events.
C3dFile recording(int type) {
  C3dFile file;
  file.markers = markers();
  file.computed = {.labels = {"LKneeAngles"},
                   .kinds = {"ANGLES"},
                   .units = {"deg"},
                   .values = RowMatrix::Constant(6, 3, 12.5)};
  file.analog = {.labels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
                 .units = {"N", "N", "N", "Nmm", "Nmm", "Nmm"},
                 .rate = 300.0,
                 .samples_per_frame = 3,
                 .values = RowMatrix::Constant(18, 6, 64.0)};
  file.events = {
      {.time = 0.01, .label = "Foot Strike", .context = "Left", .subject = "", .description = ""},
      {.time = 0.02,
       .label = "END",
       .context = "",
       .subject = "",
       .description = "",
       .in_header = true}};
  const auto set = [&](const char* group, C3dParameter parameter) {
    set_parameter(file.groups, group, std::move(parameter));
  };
  set("POINT", C3dParameter::of_texts("ANGLES", {"LKneeAngles"}));
  set("POINT", C3dParameter::of_text("X_SCREEN", "+X"));
  set("POINT", C3dParameter::of_text("Y_SCREEN", "+Z"));
  set("FORCE_PLATFORM", C3dParameter::of_integers("USED", {}, {1}));
  set("FORCE_PLATFORM", C3dParameter::of_integers("TYPE", {1}, {static_cast<std::int16_t>(type)}));
  set("FORCE_PLATFORM", C3dParameter::of_integers("ZERO", {2}, {1, 2}));
  set("FORCE_PLATFORM", C3dParameter::of_integers("CHANNEL", {6, 1}, {1, 2, 3, 4, 5, 6}));
  set("FORCE_PLATFORM", C3dParameter::of_reals("ORIGIN", {3, 1}, {0, 0, -40}));
  set("FORCE_PLATFORM",
      C3dParameter::of_reals("CORNERS", {3, 4, 1}, {600, 0, 0, 0, 0, 0, 0, 400, 0, 600, 400, 0}));
  if (type == 4) {
    std::vector<float> identity(36);
    for (std::size_t i = 0; i < 6; ++i) identity[7 * i] = 1.0f;
    set("FORCE_PLATFORM", C3dParameter::of_reals("CAL_MATRIX", {6, 6, 1}, identity));
  }
  set("TRIAL", C3dParameter::of_integers("ACTUAL_START_FIELD", {2}, {1, 0}));
  set("TRIAL", C3dParameter::of_integers("ACTUAL_END_FIELD", {2}, {6, 0}));
  return file;
}

TimeTable table() {
  TimeTable result;
  result.name = "Coordinates";
  result.labels = {"pelvis_tilt", "/jointset/knee_r/knee_angle_r/value", "ground_force_vx"};
  result.time = Eigen::Vector4d(0.0, 0.01, 0.02, 0.02);
  result.values = RowMatrix::Constant(4, 3, -1.5e-3);
  result.values(1, 2) = std::nan("");
  result.header["DataType"] = "double";
  return result;
}

Joint joint(const char* name, Joint::Kind kind, int parent, int child) {
  Joint result;
  result.name = name;
  result.kind = kind;
  result.parent = parent;
  result.child = child;
  return result;
}

// A free trunk, a leg on a pin, a marker.
MusculoskeletalModel model() {
  MusculoskeletalModel result;
  result.name = "seed";
  for (const char* name : {"ground", "trunk", "leg"}) {
    Body body;
    body.name = name;
    if (!result.bodies.empty()) {
      body.mass = 10.0;
      body.I_BCm = 0.1 * Eigen::Matrix3d::Identity();
    }
    result.bodies.push_back(body);
  }
  result.joints = {joint("root", Joint::Kind::kFree, 0, 1), joint("hip", Joint::Kind::kPin, 1, 2)};
  for (const char* name : {"rx", "ry", "rz", "tx", "ty", "tz", "hip_flexion"}) {
    Coordinate coordinate;
    const int index = static_cast<int>(result.coordinates.size());
    coordinate.name = name;
    coordinate.joint = index < 6 ? 0 : 1;
    coordinate.motion =
        name[0] == 't' ? Coordinate::Motion::kTranslational : Coordinate::Motion::kRotational;
    coordinate.range_min = -2.0;
    coordinate.range_max = 2.0;
    result.joints[static_cast<std::size_t>(coordinate.joint)].coordinates.push_back(index);
    result.coordinates.push_back(coordinate);
  }
  Marker marker;
  marker.name = "KNEE";
  marker.body = 2;
  marker.p_BM = Eigen::Vector3d(0.0, -0.4, 0.05);
  result.markers = {marker};
  return result;
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: make_seeds FOLDER\n");
    return 2;
  }
  const fs::path folder = arguments[1];
  for (const int type : {2, 4}) {
    for (const bool integers : {false, true}) {
      write_c3d(folder / "c3d" / ("own_" + std::to_string(type) + (integers ? "i" : "r")),
                recording(type), {.integers = integers});
    }
  }
  write_trc(folder / "trc" / "own", markers());
  write_storage(folder / "storage" / "own", table());
  TimeTable degrees = table();
  degrees.in_degrees = true;
  write_storage(folder / "storage" / "own_degrees", degrees);
  write_file_atomically(folder / "osim" / "own", write_osim(model()));
  return 0;
}
