#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "data/tool_setup.h"

namespace sinew {

/// A body that a measurement scales, and along which of its axes.
struct BodyScale {
  std::string body;
  std::array<bool, 3> axes{};  // x, y, z
  int line = 0;
};

/// One Measurement: how far apart pairs of markers are tells how long bodies are.
struct ScaleMeasurement {
  struct Pair {
    std::string first, second;  // names of markers
    int line = 0;
  };

  std::string name;
  bool apply = true;
  std::vector<Pair> pairs;
  std::vector<BodyScale> bodies;
  int line = 0;
};

/// One Scale of a ScaleSet: the factors of a body, given.
struct ManualScale {
  std::string body;
  Eigen::Vector3d factors = Eigen::Vector3d::Ones();  // > 0
  bool apply = true;
  int line = 0;

  bool operator==(const ManualScale&) const = default;
};

struct ScaleSet {
  std::string path;
  std::vector<ManualScale> scales;
};

/// The GenericModelMaker of a ScaleTool. Paths as in IkSetup.
struct GenericModelSetup {
  std::string path;
  std::filesystem::path model_file;       // empty where the setup names none
  std::filesystem::path marker_set_file;  // "
  SetupLines lines;
};

/// Its ModelScaler.
struct ModelScalerSetup {
  enum class Step { kMeasurements, kManual };

  std::string path;
  bool apply = false;                          // false where the setup has none
  std::vector<Step> order;                     // later steps overwrite what earlier ones found
  std::string measurement_path;                // of the file that has the measurements
  std::vector<ScaleMeasurement> measurements;  // in order; later ones overwrite axes
  ScaleSet manual;
  std::filesystem::path marker_file;
  std::optional<double> from, to;  // time_range of marker_file [s]
  bool preserve_mass_distribution = false;
  std::filesystem::path output_model_file, output_scale_file;
  SetupLines lines;
};

/// Its MarkerPlacer.
struct MarkerPlacerSetup {
  std::string path;
  bool apply = false;
  IkTaskSet task_set;
  std::filesystem::path marker_file, coordinate_file;
  std::optional<double> from, to;  // time_range of marker_file [s]
  std::filesystem::path output_model_file, output_motion_file, output_marker_file;
  std::optional<double> max_marker_movement;  // [m]; the file's negative number is none
  SetupLines lines;
};

/// OpenSim's ScaleTool.
struct ScaleSetup {
  std::string path;
  std::string name;            // of the subject, and so of the scaled model
  std::optional<double> mass;  // [kg]; the file's negative number is none
  GenericModelSetup generic;
  ModelScalerSetup scaler;
  MarkerPlacerSetup placer;
  std::vector<Warning> warnings;
};

/// Reads the tool from an OpenSimDocument of any version. Measurements, scales and tasks may stand
/// in files of their own (the attribute `file`). Throws InputError naming file, line and element
/// for a wrong root, a malformed field, a marker pair that is none, a factor that is none, an
/// unknown step or axis.
ScaleSetup read_scale_setup(const std::filesystem::path& path);

/// The scales of a <ScaleSet> document or of a whole setup.
ScaleSet read_scale_set(const std::filesystem::path& path);

/// A table of scale factors, comma-separated: a body and one factor, or three for its x, y and z
/// axes, in each row; a first row whose second cell is no number is a heading. Lines that begin
/// with # are left out. Throws InputError naming line and cell.
ScaleSet read_scale_table(const std::filesystem::path& path);

/// As OpenSim writes the scales that it applied.
std::string write_scale_set(const ScaleSet& set);

}  // namespace sinew
