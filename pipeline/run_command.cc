#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "data/output_file.h"
#include "data/storage_file.h"
#include "pipeline/command.h"
#include "pipeline/dynamics_evidence.h"
#include "pipeline/example.h"
#include "pipeline/filter_reasons.h"
#include "pipeline/id_job.h"
#include "pipeline/id_options.h"
#include "pipeline/ik_job.h"
#include "pipeline/ik_options.h"
#include "pipeline/lab_job.h"
#include "pipeline/lab_loads.h"
#include "pipeline/lab_options.h"
#include "pipeline/load_placement.h"
#include "pipeline/output_check.h"
#include "pipeline/reports.h"
#include "pipeline/run_digest.h"
#include "pipeline/trace.h"
#include "pipeline/undetermined.h"
#include "pipeline/verdict_evidence.h"
#include "pipeline/verdict_reasons.h"
#include "pipeline/verdict_report.h"
#include "pipeline/version.h"
#include "pipeline/wire_report.h"

namespace sinew {
namespace {

constexpr const char* kResults[] = {"ik.mot",           "id.sto",       "marker_errors.csv",
                                    "frame_errors.csv", "summary.json", "verdict.json"};
constexpr const char* kWires = "wires.csv";  // of models with wires

struct RunCommand {
  CLI::App* command = nullptr;
  IkOptions ik;
  IdOptions dynamics;
  LabOptions lab;
  std::string out = "sinew-results";
  bool accept = false;

  // A laboratory's files, or those of a run that is repeated, become model, markers and loads.
  LabJob prepare(DecisionLog& log, std::vector<Warning>& warnings) {
    if (!lab.decisions.empty()) {
      log = DecisionLog(lab.decisions);
      lab.given_now = take_replayed_options(*command, log);
      report(warnings, log.changed_inputs());
      // Beside the file that was edited.
      if (!lab.given_now.contains("--out")) {
        out = std::filesystem::path(lab.decisions).parent_path().string();
        if (out.empty()) out = ".";
      }
    } else {
      lab.given_now = take_replayed_options(*command, log);
    }
    if (!ik.markers.empty()) {
      throw std::invalid_argument(
          "--c3d and --markers are two ways to give the same: leave one of them out");
    }
    lab.validate();
    say_options(*command, lab.given_now, log);
    std::vector<std::filesystem::path> outputs = lab_outputs(out);
    for (const char* name : kResults) outputs.push_back(std::filesystem::path(out) / name);
    check_outputs(outputs, {{"c3d", lab.c3d},
                            {"static", lab.static_trial},
                            {"model", ik.model},
                            {"map", lab.map},
                            {"marker_set", lab.marker_set},
                            {"tasks", ik.tasks},
                            {"loads", dynamics.loads},
                            {"scale_setup", lab.scale_setup}});
    LabJob job = prepare_lab(lab, ik, dynamics, out, log, warnings);
    ik = job.ik;
    dynamics = job.dynamics;
    return job;
  }

  // Without any file the embedded walk is written to the output folder and run from there.
  void use_example() {
    if (!ik.tasks.empty() || !ik.coordinates.empty() || !dynamics.loads.empty() ||
        !dynamics.load_data.empty()) {
      throw std::invalid_argument(
          "no model and no markers for the other files: give --model FILE.osim and --markers "
          "FILE.trc, or no file at all for the embedded walk");
    }
    const std::filesystem::path folder = std::filesystem::path(out) / "example";
    check_outputs({folder / "model.osim"}, {});
    write_example(folder);
    fmt::print("no model given: running the embedded walk, written to {}\n", folder.string());
    ik.model = (folder / "model.osim").string();
    ik.markers = (folder / "walk.trc").string();
    ik.tasks = (folder / "ik_tasks.xml").string();
    dynamics.loads = (folder / "grf.xml").string();
    // The usual tolerance would leave the weakly held lumbar spine beside its minimum.
    ik.tolerance = std::min(ik.tolerance, 1e-11);
    // Markers without noise need no filter, and one would take part of the motion away.
    if (!dynamics.cutoff) dynamics.cutoff = -1.0;
  }

  int run() {
    const auto start = std::chrono::steady_clock::now();
    std::vector<Warning> warnings;
    DecisionLog log;
    std::optional<LabJob> lab_job;
    if (!lab.c3d.empty() || !lab.decisions.empty()) {
      lab_job = prepare(log, warnings);
    } else {
      LabOptions::require_none(*command);
    }
    if (ik.model.empty() && ik.markers.empty()) use_example();
    IkInputs inputs = ik.inputs();
    inputs.name_unmatched = inputs.check_recording = !lab_job;  // or else it was done before
    inputs.recorded_names = recorded_names(log);
    inputs.reach = filter_reach(dynamics.cutoff.value_or(kDefaultCutoff));
    if (lab_job) inputs.reach = std::max(inputs.reach, filter_reach(lab_job->marker_cutoff));
    ik.require_files(inputs);
    InputFiles files = input_files(inputs);
    files.emplace_back("loads", dynamics.loads);
    files.emplace_back("load_data", dynamics.load_data);
    check_results(files);

    IkJob job = prepare_ik(inputs);
    report(warnings, job.warnings);
    IdJob id_job = prepare_id(job.model, dynamics, std::nullopt, ik.threads, warnings);
    files.back().second = id_job.load_data_file;
    check_results(files);
    check_motion_times(frame_times(job), id_job, job.recording.path);
    nlohmann::ordered_json summary;
    summary["versions"] = component_versions();
    summary["inputs"] = input_summary(files);

    const std::optional<TrackingResult> solved = solve_ik(job);
    if (!solved) return kExitFailed;
    report(warnings, frame_warnings(*solved, job.recording.path));
    const std::vector<VerdictReason> findings = tracking_findings(job, *solved);
    const std::vector<std::string> undetermined = undetermined_names(findings);
    const auto id_start = std::chrono::steady_clock::now();
    // Three times as far as what is filtered is seen: accelerations are spoiled farther than
    // angles.
    const std::optional<CoordinateTable> solved_motion =
        motion_around(job, *solved, 3.0 * filter_reach(id_job.options.cutoff));
    if (!solved_motion) return kExitFailed;
    id_job.options.from = solved->time[0];
    id_job.options.to = solved->time[solved->time.size() - 1];
    std::optional<InverseDynamicsResult> torques = solve_id(job.model, *solved_motion, id_job);
    if (!torques) return kExitFailed;
    report(warnings, torques->warnings);

    summary["options"] = option_summary(job, id_job, *solved);
    summary["inverse_kinematics"] = ik_summary(job.tracking, *solved, job.options);
    if (!job.tracking.wires.empty()) summary["wires"] = wire_summary(job.tracking, *solved);
    summary["inverse_dynamics"] = id_summary(job.model, torques->forces);
    summary["inverse_dynamics"]["seconds"] = seconds_since(id_start);
    if (lab_job) {
      summary["laboratory"] = input_summary(lab_job->inputs);
      summary["decisions"] = log.to_json()["decisions"];
    }
    mark_undetermined(undetermined, torques->forces);
    mark_stretches(job, torques->forces);
    if (lab_job && lab_job->coverage) {
      const int first = job.options.first_frame;
      summary["loads"] = coverage_summary(*lab_job->coverage, first, job.model, torques->forces);
      mark_coverage(*lab_job->coverage, first, torques->forces);
    }
    summary["inverse_kinematics"]["undetermined"] = undetermined;
    const VerdictEvidence evidence =
        gather(job, *solved, *solved_motion, torques->forces, id_job, lab_job, findings);
    const Verdict verdict = judge(evidence);
    summary["inverse_dynamics"]["root"] = root_json(*evidence.dynamics);
    summary["verdict"] = verdict_json(verdict);
    summary["warnings"] = warning_summary(warnings);
    summary["seconds"] = seconds_since(start);
    TimeTable motion = coordinate_motion(job.model, *solved);
    set_undetermined(undetermined, motion);
    write_results(job, *solved, motion, torques->forces, summary);
    write_verdict(std::filesystem::path(out) / "verdict.json", verdict);
    if (lab_job) {
      write_decisions(std::filesystem::path(out) / "decisions.json", log, lab_job->inputs,
                      given_options(*command));
    }
    fmt::print("{}", run_digest({summary, evidence, verdict, id_job.options.cutoff, out}));
    return exit_code(verdict, accept);
  }

  // Of the model's markers that a laboratory calls otherwise, without its subject.
  static std::map<std::string, std::string> recorded_names(const DecisionLog& log) {
    std::map<std::string, std::string> names;
    for (const Decision& decision : log.decisions()) {
      if (decision.name != "markers" || !decision.value.is_object()) continue;
      for (const auto& [recorded, model] : decision.value.items()) {
        const std::string bare = recorded.substr(recorded.rfind(':') + 1);
        if (model.is_string() && model != bare) names[model.get<std::string>()] = bare;
      }
    }
    return names;
  }

  static VerdictEvidence gather(const IkJob& job, const TrackingResult& solved,
                                const CoordinateTable& motion, const TimeTable& forces,
                                const IdJob& id_job, const std::optional<LabJob>& lab_job,
                                const std::vector<VerdictReason>& findings) {
    VerdictEvidence evidence;
    evidence.joints = joint_evidence(job.model);
    evidence.angles = evidence.torques = true;
    evidence.model = model_evidence(job.model);
    if (lab_job) evidence.found = lab_job->reasons;
    append(evidence.found, findings);
    // The static trial is the first of two that the model was fitted to.
    const bool standing = lab_job && lab_job->fit && lab_job->fit->trials.size() > 1;
    const double static_rms = standing ? lab_job->fit->trials.front().rms : kNaN;
    evidence.kinematics = kinematics_evidence(job, solved, static_rms, evidence.found);
    CoverageOfFrames coverage;
    if (lab_job && lab_job->coverage) {
      coverage = {&*lab_job->coverage, job.options.first_frame,
                  lab_job->carried ? lab_job->carried->mass : kNaN,
                  lab_job->standing_mass.value_or(kNaN)};
    }
    evidence.dynamics = dynamics_evidence(job.model, forces, id_job.loads, coverage);
    append(evidence.found,
           load_placement_reasons(
               job.model, load_placements(job.model, solved.time, solved.coordinates, id_job.loads),
               evidence.dynamics->supporting));
    append(evidence.found, angle_filter_reasons(job.model, motion, id_job.options.cutoff));
    return evidence;
  }

  void check_results(const InputFiles& inputs) const {
    if (out.empty()) throw std::invalid_argument("--out is empty: give --out FOLDER");
    std::vector<std::filesystem::path> outputs = {ik.trace};
    for (const char* name : kResults) outputs.push_back(std::filesystem::path(out) / name);
    outputs.push_back(std::filesystem::path(out) / kWires);
    check_outputs(outputs, inputs);
  }

  static Eigen::VectorXd frame_times(const IkJob& job) {
    return job.recording.markers.time.segment(job.options.first_frame,
                                              job.options.end_frame - job.options.first_frame);
  }

  static nlohmann::ordered_json option_summary(const IkJob& job, const IdJob& id_job,
                                               const TrackingResult& solved) {
    return {{"method", to_string(job.options.minimizer.method)},
            {"gradient_tolerance", job.options.minimizer.gradient_tolerance},
            {"cutoff_hz", id_job.options.cutoff},
            {"project_couplers", id_job.options.project_couplers},
            {"exact_custom_joints", id_job.options.exact_custom_joints},
            {"threads", job.options.threads},
            {"from_s", solved.time[0]},
            {"to_s", solved.time[solved.time.size() - 1]}};
  }

  static double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  void write_results(const IkJob& job, const TrackingResult& solved, const TimeTable& motion,
                     const TimeTable& torques, const nlohmann::ordered_json& summary) const {
    const std::filesystem::path folder = out;
    write_storage(folder / "ik.mot", motion);
    write_storage(folder / "id.sto", torques);
    write_file_atomically(folder / "marker_errors.csv",
                          marker_errors_csv(marker_errors(job.tracking, solved)));
    write_file_atomically(folder / "frame_errors.csv", frame_errors_csv(job.tracking, solved));
    if (!job.tracking.wires.empty()) {
      write_file_atomically(folder / kWires, wires_csv(job.model, job.tracking, solved));
    }
    // Names may hold bytes that are no UTF-8.
    write_file_atomically(
        folder / "summary.json",
        summary.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
    if (!ik.trace.empty()) {
      write_file_atomically(ik.trace, trace_csv(solved, job.options.first_frame));
    }
  }
};

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<RunCommand>();
  CLI::App* sub = app.add_subcommand(
      "run",
      "A laboratory's C3D file, or markers and ground forces, to joint angles and joint torques; "
      "without files, the embedded walk");
  command->ik.add_to(*sub);
  command->dynamics.add_to(*sub);
  command->lab.add_to(*sub);
  command->command = sub;
  sub->add_option("--out", command->out, "Folder for the results")->capture_default_str();
  sub->add_flag("--accept", command->accept, kAcceptHelp);
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace sinew
