#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
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
  std::string name;  // of the marker or the coordinate
  bool apply = true;
  double weight = 1.0;  // ≥ 0; the reader gives OpenSim's default 0 where the file has none
  ValueType value_type = ValueType::kDefault;  // coordinate tasks only
  double value = 0.0;  // kManual: the file's number, which OpenSim takes as radians or metres
  int line = 0;        // in IkTaskSet::path
};

struct IkTaskSet {
  std::string path;
  std::vector<IkTask> tasks;
  std::vector<Warning> warnings;
};

/// Line of each element that a setup file fills, by the element's name (`marker_file`, ...), for
/// messages about what the element names; see location_of.
using SetupLines = std::map<std::string, int>;

/// OpenSim's InverseKinematicsTool. Paths are absolute, resolved against the setup file's folder,
/// with slashes for backslashes; a path of another system (`C:\...`) stays as the file has it.
/// Nothing is said about whether the files exist. `Unassigned` is empty.
struct IkSetup {
  std::string path;
  std::string name;
  std::filesystem::path model_file;          // empty where the setup names none
  std::filesystem::path marker_file;         // "
  std::filesystem::path coordinate_file;     // "
  std::filesystem::path output_motion_file;  // "
  std::filesystem::path results_directory;   // "
  std::optional<double> from, to;            // time_range [s]
  double constraint_weight = 0.0;            // infinity where unassigned
  double accuracy = 1e-5;
  IkTaskSet task_set;
  SetupLines lines;
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
  std::filesystem::path output_file;  // output_gen_force_file under results_directory, .sto
  std::optional<double> from, to;     // [s]
  double cutoff = -1.0;               // coordinates' low-pass [Hz]; negative = no filter
  std::vector<std::string> forces_to_exclude;
  SetupLines lines;
  std::vector<Warning> warnings;
};

/// One ExternalForce: which columns of the data file act on which body, in which frames.
struct ExternalForce {
  std::string name;
  bool applies = true;
  std::string applied_to_body;
  std::string force_expressed_in_body = "ground";
  std::string point_expressed_in_body = "ground";
  // What the columns' labels begin with; empty where the load has no such part.
  std::string force_identifier, point_identifier, torque_identifier;
  // Labels of the x, y and z columns, or empty like the identifier: those of the data file if it
  // exists, else the identifier with x, y and z until bind_columns says better.
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
  SetupLines lines;
  std::vector<Warning> warnings;
};

/// Each reads the tool from an OpenSimDocument of any version, or from a document that holds only
/// the tool. Throws InputError naming file, line and element for a wrong root, a malformed field,
/// or an unknown task kind. Accepts the IKTool of OpenSim 1 and 2 too (its first trial). A task set
/// in a file of its own is read from there; that file must exist.
IkSetup read_ik_setup(const std::filesystem::path& path);
/// Accepts a bare IKTaskSet document or a whole InverseKinematicsTool.
IkTaskSet read_ik_task_set(const std::filesystem::path& path);
/// Accepts the AnalyzeTool with an InverseDynamics analysis, as OpenSim 1 and 2 wrote it, too.
IdSetup read_id_setup(const std::filesystem::path& path);
/// Reads the labels of the data file, if it exists, to find the columns of each force. Throws
/// InputError also for PrescribedForce (before OpenSim 2.4) and if an identifier does not fit
/// exactly three labels.
ExternalLoadsSetup read_external_loads(const std::filesystem::path& path);

/// Finds the columns of each force again among `labels`, for loads whose data come from `data_name`
/// instead of the setup's data_file. As in OpenSim, an identifier stands for the labels that begin
/// with it; x, y, z (or 1, 2, 3) at their ends give the order. If more than three begin with it,
/// those that go on with only an axis count, as in `force` + `_x`.
/// Throws InputError at the force's line if not exactly three fit.
void bind_columns(ExternalLoadsSetup& setup, const std::vector<std::string>& labels,
                  const std::string& data_name);

/// Where a setup names an element, for messages: its line, or the file as a whole.
template <typename Setup>
SourceLocation location_of(const Setup& setup, const std::string& element) {
  const auto found = setup.lines.find(element);
  return {setup.path, found == setup.lines.end() ? 0 : found->second};
}

}  // namespace sinew
