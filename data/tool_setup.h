#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "data/input_error.h"

namespace sinew {

/// One IKMarkerTask or IKCoordinateTask of an OpenSim IKTaskSet.
struct IkTask {
  enum class Kind { kMarker, kCoordinate };
  enum class ValueType { kDefault, kManual, kFromFile };

  Kind kind = Kind::kMarker;
  std::string name;    // of the marker or the coordinate
  bool apply = true;
  double weight = 1.0;  // ≥ 0
  ValueType value_type = ValueType::kManual;  // coordinate tasks only
  double value = 0.0;                         // kManual: as the file has it (degrees for angles? the
                                              // reader keeps the file's number)
  int line = 0;
};

struct IkTaskSet {
  std::string path;
  std::vector<IkTask> tasks;
  std::vector<Warning> warnings;
};

/// OpenSim's InverseKinematicsTool. Paths are absolute, resolved against the setup file's folder.
struct IkSetup {
  std::string path;
  std::string name;
  std::filesystem::path model_file;        // empty where the setup names none
  std::filesystem::path marker_file;       // "
  std::filesystem::path coordinate_file;   // "
  std::filesystem::path output_motion_file;  // "
  std::filesystem::path results_directory;   // "
  std::optional<double> from, to;          // time_range [s]
  double constraint_weight = 0.0;          // infinity where unassigned
  double accuracy = 1e-5;
  IkTaskSet task_set;
  std::vector<Warning> warnings;
};

/// OpenSim's InverseDynamicsTool. Paths as in IkSetup.
struct IdSetup {
  std::string path;
  std::string name;
  std::filesystem::path model_file;
  std::filesystem::path external_loads_file;
  std::filesystem::path coordinates_file;
  std::filesystem::path results_directory;
  std::filesystem::path output_file;       // output_gen_force_file under results_directory
  std::optional<double> from, to;          // [s]
  double cutoff = -1.0;                    // coordinates' low-pass [Hz]; negative = no filter
  std::vector<std::string> forces_to_exclude;
  std::vector<Warning> warnings;
};

/// One ExternalForce: which columns of the data file act on which body, in which frames.
struct ExternalForce {
  std::string name;
  bool applies = true;
  std::string applied_to_body;
  std::string force_expressed_in_body = "ground";
  std::string point_expressed_in_body = "ground";
  // Column labels of the three components; empty where the load has no such part.
  std::vector<std::string> force_columns, point_columns, torque_columns;
  int line = 0;
};

/// OpenSim's ExternalLoads. Paths as in IkSetup.
struct ExternalLoadsSetup {
  std::string path;
  std::vector<ExternalForce> forces;
  std::filesystem::path data_file;
  std::filesystem::path model_kinematics_file;  // deprecated; empty in current files
  double kinematics_cutoff = -1.0;              // [Hz]; deprecated, used with the line above
  std::vector<Warning> warnings;
};

/// Each reads the tool from an OpenSimDocument of any version. Throws InputError naming file,
/// line and element for a wrong root, a missing or malformed field, or an unknown task kind.
IkSetup read_ik_setup(const std::filesystem::path& path);
/// Accepts a bare IKTaskSet document or a whole InverseKinematicsTool.
IkTaskSet read_ik_task_set(const std::filesystem::path& path);
IdSetup read_id_setup(const std::filesystem::path& path);
ExternalLoadsSetup read_external_loads(const std::filesystem::path& path);

}  // namespace sinew
