#include "pipeline/lab_job.h"

#include <fmt/format.h>

#include <stdexcept>

#include "data/carried_mass.h"
#include "data/frame_continuity.h"
#include "data/input_file.h"
#include "data/marker_matching.h"
#include "data/mass_unit.h"
#include "data/numbers.h"
#include "data/output_file.h"
#include "data/static_trial.h"
#include "data/storage_file.h"
#include "data/trc_file.h"
#include "model/osim_file.h"
#include "model/whole_body.h"
#include "pipeline/command.h"
#include "pipeline/filter_reasons.h"
#include "pipeline/finding_reasons.h"
#include "pipeline/ground_reaction.h"
#include "pipeline/lab_attach.h"
#include "pipeline/lab_loads.h"
#include "pipeline/lab_model.h"
#include "pipeline/lab_motion.h"
#include "pipeline/lab_names.h"
#include "pipeline/lab_recording.h"
#include "pipeline/preflight_files.h"
#include "pipeline/setup_files.h"
#include "pipeline/verdict_reasons.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

constexpr const char* kModel = "model.osim";
constexpr const char* kGeneric = "model_generic.osim";
constexpr const char* kAttached = "attached_markers.xml";
constexpr const char* kMarkers = "markers.trc";
constexpr const char* kStatic = "static.trc";
constexpr const char* kFilled = "filled.csv";
constexpr const char* kForces = "grf.mot";
constexpr const char* kLoads = "grf.xml";
constexpr const char* kCoverage = "load_coverage.csv";
constexpr const char* kTasks = "ik_tasks.xml";
constexpr const char* kPosture = "posture.mot";
constexpr const char* kIkSetup = "ik_setup.xml";
constexpr const char* kIdSetup = "id_setup.xml";

// What the steps hand on.
class Preparation {
 public:
  Preparation(const LabOptions& options, IkOptions ik, IdOptions dynamics, const fs::path& folder,
              DecisionLog& log, std::vector<Warning>& warnings)
      : options_(options), folder_(folder), log_(log), warnings_(warnings) {
    job_.ik = std::move(ik);
    job_.dynamics = std::move(dynamics);
  }

  LabJob prepare() {
    gather_inputs();
    threshold_ = log_.settle_number({"threshold",
                                     {},
                                     kContactForce,
                                     "[N] what laboratories use",
                                     {},
                                     "",
                                     "--threshold",
                                     Decision::Range::kZeroOrMore},
                                    true);
    LabTrial walk = read_lab_recording(options_.c3d, "", threshold_, nullptr, log_, warnings_);
    entered_ = subject_parameters(walk.file);
    const GenericModel generic = generic_model(job_.ik.model, entered_, options_, folder_, log_);
    report(warnings_, generic.model.warnings);
    check_first(generic, walk);
    note(frame_reasons(walk.file.markers));
    MarkerTrajectories markers = name(walk, "", generic.model);
    const GapFillResult filled =
        fill_lab_markers(markers, walk.file.path, generic.file, folder_ / kFilled, log_, warnings_);
    scale(generic, walk, well_filled(markers, filled));
    attach(markers);
    const MarkerTrajectories unfiltered = markers;
    job_.marker_cutoff = filter_lab_markers(markers, walk.file.path, log_, warnings_);
    note(marker_filter_reasons(unfiltered, markers, job_.marker_cutoff));
    write_trc(folder_ / kMarkers, markers);
    settle_motion(markers);
    assign_loads(walk, markers);
    check_mass_unit();
    write_setups();
    return std::move(job_);
  }

 private:
  void gather_inputs() {
    job_.inputs = {{"c3d", options_.c3d},
                   {"static", options_.static_trial},
                   {"map", options_.map},
                   {"scale_setup", options_.scale_setup},
                   {"marker_set", options_.marker_set},
                   {"tasks", job_.ik.tasks},
                   {"task_coordinates", job_.ik.coordinates},
                   {"loads", job_.dynamics.loads},
                   {"load_data", job_.dynamics.load_data}};
    if (!find_whole_body(job_.ik.model)) job_.inputs.emplace_back("model", job_.ik.model);
  }

  // What would still spoil the run, and what mends it, before anything is solved.
  void check_first(const GenericModel& generic, const LabTrial& walk) {
    PreflightFiles files;
    files.read_model(generic.file.string());
    files.read(options_.c3d, walk.edits);
    RecordingEdits unit;
    unit.unit = options_.edit.unit;
    if (!options_.static_trial.empty()) files.read(options_.static_trial, unit);
    std::vector<Warning> spoiling;
    const std::vector<Finding> findings = run_preflight(files.inputs());
    const Eigen::VectorXd& time = walk.file.markers.time;
    note(finding_reasons(findings, time[0], time[time.size() - 1], options_.static_trial));
    for (const Finding& finding : findings) {
      if (finding.severity == Finding::Severity::kNote || finding.confidence < kLikely) continue;
      // A generic model is of another size until it is scaled.
      if (finding.kind == "size" && will_fit_sizes(generic)) continue;
      if (finding.kind == "match") continue;  // names are settled next
      if (finding.kind == "spike") continue;  // settled as they are read
      const std::string mends = run_remedy(finding, options_.static_trial);
      spoiling.push_back(
          {{finding.file.empty() ? options_.c3d : finding.file},
           fmt::format("{}{}{} ({}){}{}", finding.where, finding.where.empty() ? "" : ": ",
                       finding.text, confidence_word(finding.confidence),
                       mends.empty()           ? ""
                       : finding.flags.empty() ? "; "
                                               : "; mended by ",
                       mends)});
    }
    report(warnings_, spoiling);
  }

  bool will_fit_sizes(const GenericModel& generic) const {
    if (options_.no_scale || options_.scale == "none" || options_.scale == "mass") return false;
    return !options_.scale.empty() || !options_.static_trial.empty() ||
           !options_.scale_setup.empty() || generic.built_in;
  }

  MarkerTrajectories name(const LabTrial& trial, const std::string& which,
                          const MusculoskeletalModel& model) {
    std::vector<std::string> names;
    for (const Marker& marker : model.markers) names.push_back(marker.name);
    return name_lab_markers(trial, which, names, options_, log_, warnings_);
  }

  // Of the static trial's markers, by the model that was fitted to both trials, if one was.
  std::vector<StaticMarker> known_markers(const GenericModel& generic,
                                          const std::optional<AutoScaleResult>& fit) const {
    std::vector<StaticMarker> known;
    const bool both = fit && fit->trials.size() == 2;
    for (const std::string& name : standing_->names) {
      StaticMarker& marker = known.emplace_back();
      const int m = generic.model.find_marker(name);
      if (m < 0) continue;
      marker.segment = generic.model.markers[static_cast<std::size_t>(m)].body;
      if (!both) continue;
      marker.change = (fit->trials[0].residuals.row(m) - fit->trials[1].residuals.row(m)).norm();
    }
    return known;
  }

  void scale(const GenericModel& generic, const LabTrial& walk, const MarkerTrajectories& markers) {
    const MarkerFile walking{walk.file.path, markers, {}};
    std::optional<MarkerFile> standing;
    std::vector<ForcePlatformRecording> plates;
    if (!options_.static_trial.empty()) {
      const LabTrial trial = read_lab_recording(options_.static_trial, "static ", threshold_,
                                                &walk.file.markers, log_, warnings_);
      standing = MarkerFile{trial.file.path, name(trial, "static ", generic.model), {}};
      plates = trial.plates;
      write_trc(folder_ / kStatic, standing->markers);
      standing_ = standing->markers;
    }
    SettledModel settled =
        settle_model(generic, walking, standing ? &*standing : nullptr, plates, entered_, options_,
                     job_.ik.threads, folder_ / kModel, log_, warnings_);
    if (standing_) {
      std::vector<VerdictReason> reasons = static_trial_reasons(*standing_, markers);
      if (reasons.empty()) {
        reasons = static_marker_reasons(*standing_, markers, known_markers(generic, settled.fit));
      }
      // Where no size follows from it, it spoils none.
      const bool used = settled.by == "static" || settled.by == "both" || settled.by == "setup";
      for (VerdictReason& reason : reasons) {
        if (!used && reason.code != "trials-exchanged")
          reason.weight = VerdictReason::Weight::kRemark;
      }
      note(reasons);
    }
    note(settled.reasons);
    if (settled.fit && settled.fit->trials.size() == 2) {
      note(static_pose_reasons(settled.fit->trials[0].rms));
      note(static_against_walk_reasons(settled.fit->trials[0].rms, settled.fit->trials[1].rms));
    } else if (settled.fit && settled.by == "static") {
      note(static_pose_reasons(settled.fit->rms_after));
    }
    model_ = std::move(settled.model);
    job_.fit = std::move(settled.fit);
    entered_mass_ = settled.mass;
    standing_mass_ = standing_mass(plates);
    job_.ik.model = (folder_ / kModel).string();
  }

  void attach(const MarkerTrajectories& markers) {
    // Given tasks say which markers are tracked: others would only stand in the model.
    if (!job_.ik.tasks.empty() && options_.attach.empty()) return;
    attach_lab_markers(
        {&markers, standing_ ? &*standing_ : nullptr, folder_ / kModel, folder_ / kAttached},
        options_, job_.ik.threads, log_);
    model_ = read_osim(folder_ / kModel);
  }

  void settle_motion(const MarkerTrajectories& markers) {
    const auto [from, to] = settle_range(markers, model_, log_);
    job_.ik.from = from;
    job_.ik.to = to;
    job_.ik.markers = (folder_ / kMarkers).string();
    job_.ik.filled = (folder_ / kFilled).string();
    job_.ik.filled_weight = log_.settle_number(
        {"filled weight",
         {},
         kFilledWeight,
         "of a measured marker's where nothing tells how well it was filled; better ones weigh "
         "more",
         {},
         "",
         "--filled-weight",
         Decision::Range::kShare},
        true);
    if (job_.ik.tasks.empty()) {
      const LabTasks tasks = lab_tasks(markers, model_, job_.ik.threads, log_);
      write_file_atomically(folder_ / kTasks, ik_tasks_document("lab", tasks.tasks));
      job_.ik.tasks = (folder_ / kTasks).string();
      if (tasks.posture) {
        write_storage(folder_ / kPosture, *tasks.posture);
        job_.ik.coordinates = (folder_ / kPosture).string();
      }
    }
    job_.dynamics.cutoff =
        log_.settle_number({"coordinate cutoff",
                            {},
                            -1.0,
                            "not filtered again: the markers are filtered as the forces are, and "
                            "weights run smoothly into gaps",
                            {},
                            "",
                            "--cutoff",
                            Decision::Range::kCutoff});
  }

  void assign_loads(LabTrial& walk, const MarkerTrajectories& markers) {
    if (!job_.dynamics.loads.empty()) return;
    if (!has_platforms(walk.plates)) {
      report(warnings_,
             {{{walk.file.path},
               "has no force platform that can be used: torques lack whatever the ground does; "
               "--loads FILE.xml gives forces from elsewhere"}});
      return;
    }
    const FootAssignment assignment =
        settle_contacts(walk.plates, markers, walk.file.path, model_, threshold_,
                        job_.marker_cutoff, options_, log_);
    write_ground_reactions(assignment, walk.plates, foot_loads(assignment, walk.plates),
                           folder_ / kForces, folder_ / kLoads);
    job_.dynamics.loads = (folder_ / kLoads).string();
    job_.coverage = load_coverage(markers, assignment, walk.plates);
    write_file_atomically(folder_ / kCoverage, load_coverage_csv(*job_.coverage, markers.time));
    job_.standing_mass = standing_mass_;
    job_.carried = stride_mass(assignment, *job_.coverage, markers.time, walk.plates);
  }

  // In pounds, or newtons?
  void check_mass_unit() {
    if (!entered_mass_) return;
    MassEvidence evidence{standing_mass_, entered_.height};
    if (job_.carried) evidence.carried = job_.carried->mass;
    if (options_.height) evidence.height = options_.height;
    note(mass_unit_reasons(*entered_mass_, evidence));
  }

  void note(const std::vector<VerdictReason>& reasons) { append(job_.reasons, reasons); }

  // Paths are relative, so that the folder can be moved; those of the user's own files are not.
  void write_setups() const {
    IkSetup ik;
    ik.name = "lab";
    ik.model_file = kModel;
    ik.marker_file = kMarkers;
    const fs::path tasks = job_.ik.tasks;
    ik.task_set.path =
        tasks == folder_ / kTasks ? kTasks : fs::absolute(tasks).lexically_normal().string();
    const fs::path posture = job_.ik.coordinates;
    if (posture == folder_ / kPosture) {
      ik.coordinate_file = kPosture;
    } else if (!posture.empty()) {
      ik.coordinate_file = fs::absolute(posture).lexically_normal();
    }
    ik.from = job_.ik.from;
    ik.to = job_.ik.to;
    ik.output_motion_file = "ik.mot";
    write_file_atomically(folder_ / kIkSetup, ik_setup_document(ik));
    IdSetup id;
    id.name = "lab";
    id.model_file = kModel;
    id.coordinates_file = "ik.mot";
    const fs::path loads = job_.dynamics.loads;
    if (!loads.empty()) {
      id.external_loads_file =
          loads == folder_ / kLoads ? fs::path(kLoads) : fs::absolute(loads).lexically_normal();
    }
    id.from = job_.ik.from;
    id.to = job_.ik.to;
    id.cutoff = job_.dynamics.cutoff.value_or(-1.0);
    id.output_file = "id.sto";
    write_file_atomically(folder_ / kIdSetup, id_setup_document(id));
  }

  const LabOptions& options_;
  const fs::path folder_;
  DecisionLog& log_;
  std::vector<Warning>& warnings_;
  double threshold_ = kContactForce;
  SubjectParameters entered_;
  std::optional<double> entered_mass_, standing_mass_;  // [kg]
  MusculoskeletalModel model_;
  std::optional<MarkerTrajectories> standing_;
  LabJob job_;
};

}  // namespace

std::vector<fs::path> lab_outputs(const fs::path& folder) {
  std::vector<fs::path> outputs;
  for (const char* name : {kModel, kGeneric, kAttached, kMarkers, kStatic, kFilled, kForces, kLoads,
                           kCoverage, kTasks, kPosture, kIkSetup, kIdSetup, "decisions.json"}) {
    outputs.push_back(folder / name);
  }
  outputs.push_back(contacts_path(folder / kForces));
  return outputs;
}

LabJob prepare_lab(const LabOptions& options, IkOptions ik, IdOptions dynamics,
                   const fs::path& folder, DecisionLog& log, std::vector<Warning>& warnings) {
  options.validate();
  if (ik.model.empty()) {
    throw std::invalid_argument(
        "no model: give --model FILE.osim, or one of the built-in bodies, whole-body and "
        "whole-body-detailed");
  }
  return Preparation(options, std::move(ik), std::move(dynamics), folder, log, warnings).prepare();
}

void write_decisions(const fs::path& file, const DecisionLog& log, const InputFiles& inputs,
                     const nlohmann::ordered_json& options) {
  nlohmann::ordered_json json = log.to_json(), files = nlohmann::ordered_json::object();
  for (const auto& [role, path] : inputs) {
    if (path.empty()) continue;
    const fs::path relative = fs::absolute(path).lexically_normal().lexically_relative(
        fs::absolute(file).lexically_normal().parent_path());
    files[role] = {{"path", relative.generic_string()}, {"sha256", sha256_of_file(path)}};
  }
  json["inputs"] = files;
  json["options"] = options;
  write_file_atomically(file, json.dump(2) + "\n");
}

}  // namespace sinew
