#include "pipeline/setup_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "data/tool_setup.h"
#include "data/xml_file.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;
using Severity = Finding::Severity;

class SetupCheck {
 public:
  explicit SetupCheck(std::string path) : path_(std::move(path)) {}

  std::vector<Finding> run() {
    switch (kind()) {
      case Kind::kIk:
        check_ik(read_ik_setup(path_));
        break;
      case Kind::kId:
        check_id(read_id_setup(path_));
        break;
      case Kind::kLoads:
        check_loads(read_external_loads(path_));
        break;
      case Kind::kTasks:
        check_tasks(read_ik_task_set(path_));
        break;
      case Kind::kOther:
        throw InputError({path_},
                         {"holds no setup that Sinew checks",
                          "InverseKinematicsTool, InverseDynamicsTool, ExternalLoads or IKTaskSet",
                          root_, "Leave it out."});
    }
    std::stable_sort(findings_.begin(), findings_.end(),
                     [](const Finding& a, const Finding& b) { return a.severity < b.severity; });
    return std::move(findings_);
  }

 private:
  enum class Kind { kIk, kId, kLoads, kTasks, kOther };

  // The outermost element that is a tool, as the readers find it.
  Kind kind() {
    const XmlFile xml{fs::path(path_)};
    root_ = xml.root().name();
    static const std::pair<const char*, Kind> kTools[] = {
        {"InverseKinematicsTool", Kind::kIk}, {"IKTool", Kind::kIk},
        {"InverseDynamicsTool", Kind::kId},   {"AnalyzeTool", Kind::kId},
        {"ExternalLoads", Kind::kLoads},      {"IKTaskSet", Kind::kTasks}};
    const std::function<Kind(pugi::xml_node, int)> search = [&](pugi::xml_node node, int depth) {
      for (const auto& [name, tool] : kTools) {
        if (std::string_view(node.name()) == name) return tool;
      }
      for (const pugi::xml_node child : node.children()) {
        if (depth == 0) break;
        const Kind found = search(child, depth - 1);
        if (found != Kind::kOther) return found;
      }
      return Kind::kOther;
    };
    return search(xml.root(), 1);
  }

  void add(Severity severity, const SourceLocation& at, std::string text, std::string advice) {
    Finding finding;
    finding.severity = severity;
    finding.kind = "setup";
    finding.file = path_;
    if (at.line > 0) finding.where = fmt::format("line {}", at.line);
    finding.text = std::move(text);
    finding.confidence = 1.0;
    finding.advice = std::move(advice);
    findings_.push_back(std::move(finding));
  }

  void warn(const std::vector<Warning>& warnings) {
    for (const Warning& warning : warnings) add(Severity::kNote, warning.at, warning.text, "");
  }

  template <typename Setup>
  void require(const Setup& setup, const char* element, const fs::path& file) {
    std::error_code error;
    if (file.empty() || fs::exists(file, error)) return;
    add(Severity::kError, location_of(setup, element),
        fmt::format("{} names {}, which is not there", element, file.string()),
        "correct the path, or name the file on the command line");
  }

  void check_tasks(const IkTaskSet& tasks) {
    warn(tasks.warnings);
    const bool any = std::any_of(tasks.tasks.begin(), tasks.tasks.end(), [](const IkTask& task) {
      return task.apply && task.weight > 0.0 && task.kind == IkTask::Kind::kMarker;
    });
    if (any || tasks.tasks.empty()) return;
    add(Severity::kWarning, {tasks.path}, "no task of a marker applies with a weight above 0",
        "give the markers weights");
  }

  void check_ik(const IkSetup& setup) {
    warn(setup.warnings);
    require(setup, "model_file", setup.model_file);
    require(setup, "marker_file", setup.marker_file);
    require(setup, "coordinate_file", setup.coordinate_file);
    check_tasks(setup.task_set);
  }

  void check_id(const IdSetup& setup) {
    warn(setup.warnings);
    require(setup, "model_file", setup.model_file);
    require(setup, "coordinates_file", setup.coordinates_file);
    require(setup, "external_loads_file", setup.external_loads_file);
    if (setup.external_loads_file.empty()) {
      add(Severity::kNote, {}, "no external loads: the pelvis carries the whole weight", "");
    }
    if (setup.cutoff < 0.0) {
      add(Severity::kNote, {}, "coordinates are not filtered",
          "--cutoff 6 unless they were filtered before");
    }
  }

  void check_loads(const ExternalLoadsSetup& setup) {
    warn(setup.warnings);
    require(setup, "datafile", setup.data_file);
    for (const ExternalForce& force : setup.forces) {
      if (force.applies && !force.applied_to_body.empty()) continue;
      add(Severity::kNote, {setup.path, force.line},
          fmt::format("force '{}' does not apply", force.name), "");
    }
  }

  const std::string path_;
  std::string root_;
  std::vector<Finding> findings_;
};

}  // namespace

std::vector<Finding> check_setup(const std::string& path) { return SetupCheck(path).run(); }

}  // namespace sinew
