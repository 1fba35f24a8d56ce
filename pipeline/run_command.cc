#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>

#include "data/output_file.h"
#include "data/storage_file.h"
#include "ik/angle_jumps.h"
#include "pipeline/command.h"
#include "pipeline/example.h"
#include "pipeline/id_job.h"
#include "pipeline/id_options.h"
#include "pipeline/ik_job.h"
#include "pipeline/ik_options.h"
#include "pipeline/lab_job.h"
#include "pipeline/lab_loads.h"
#include "pipeline/lab_options.h"
#include "pipeline/output_check.h"
#include "pipeline/reports.h"
#include "pipeline/trace.h"
#include "pipeline/undetermined.h"
#include "pipeline/version.h"
#include "pipeline/wire_report.h"

namespace sinew {
namespace {

constexpr const char* kResults[] = {"ik.mot", "id.sto", "marker_errors.csv", "frame_errors.csv",
                                    "summary.json"};
constexpr const char* kWires = "wires.csv";  // of models with wires

struct RunCommand {
  CLI::App* command = nullptr;
  IkOptions ik;
  IdOptions dynamics;
  LabOptions lab;
  std::string out = "sinew-results";

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
    inputs.name_unmatched = !lab_job;  // or else they were named before
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
    for (const VerdictReason& reason : angle_jumps(job.model, *solved)) {
      report(warnings, {{{job.recording.path}, reason.text}});
    }
    const std::vector<VerdictReason> reasons = coverage_reasons(job, *solved);
    report(warnings, as_warnings(reasons, job.recording.path));
    const std::vector<std::string> undetermined = undetermined_names(reasons);
    const auto id_start = std::chrono::steady_clock::now();
    std::optional<InverseDynamicsResult> torques =
        solve_id(job.model, coordinate_table(job.model, *solved), id_job);
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
    if (lab_job && lab_job->coverage) {
      const int first = job.options.first_frame;
      summary["loads"] = coverage_summary(*lab_job->coverage, first, job.model, torques->forces);
      mark_coverage(*lab_job->coverage, first, torques->forces);
    }
    mark_undetermined(undetermined, torques->forces);
    summary["inverse_kinematics"]["undetermined"] = undetermined;
    summary["warnings"] = warning_summary(warnings);
    summary["seconds"] = seconds_since(start);
    TimeTable motion = coordinate_motion(job.model, *solved);
    set_undetermined(undetermined, motion);
    write_results(job, *solved, motion, torques->forces, summary);
    if (lab_job) {
      write_decisions(std::filesystem::path(out) / "decisions.json", log, lab_job->inputs,
                      given_options(*command));
    }
    print_digest(*solved, summary, id_job.options.cutoff);
    return unconverged_frames(*solved) == 0 ? kExitOk : kExitFailed;
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
    write_file_atomically(folder / "summary.json", summary.dump(2) + "\n");
    if (!ik.trace.empty()) {
      write_file_atomically(ik.trace, trace_csv(solved, job.options.first_frame));
    }
  }

  void print_digest(const TrackingResult& solved, const nlohmann::ordered_json& summary,
                    double cutoff) const {
    const auto& kinematics = summary["inverse_kinematics"];
    fmt::print("inverse kinematics: {} frames, {:.3g} ms a frame, marker RMS {:.2f} mm",
               solved.frames.size(), kinematics["ms_per_frame"].get<double>(),
               1e3 * total_marker_rms(solved));
    if (kinematics.contains("worst_marker")) {
      fmt::print(", worst marker {} ({:.1f} mm)",
                 kinematics["worst_marker"]["name"].get<std::string>(),
                 1e3 * kinematics["worst_marker"]["rms_m"].get<double>());
    }
    if (summary.contains("wires")) {
      const auto& wires = summary["wires"];
      fmt::print("\nwires: {}, of which {} become taut", wires["wires"].get<int>(),
                 wires["ever_taut"].get<int>());
      if (wires.contains("most_strained")) {
        fmt::print("; the most strained by {:.2g} %: {}",
                   100.0 * wires["most_strained"]["strain"].get<double>(),
                   wires["most_strained"]["wire"].get<std::string>());
      }
    }
    // Where loads are missing the residuals are the ground's.
    const bool partly = summary.contains("loads") &&
                        !summary["loads"]["root_residuals_where_complete"].is_null() &&
                        summary["loads"]["complete_frames"] != summary["loads"]["frames"];
    fmt::print("\ninverse dynamics: coordinates {}; residuals at the root{}:\n",
               filter_text(cutoff),
               partly ? fmt::format(" in the {} frames in which all loads are known",
                                    summary["loads"]["complete_frames"].get<int>())
                      : "");
    for (const auto& r : partly ? summary["loads"]["root_residuals_where_complete"]
                                : summary["inverse_dynamics"]["root_residuals"]) {
      fmt::print("  {:<28} RMS {:8.2f} max {:8.2f} {}\n", r["column"].get<std::string>(),
                 r["rms"].get<double>(), r["max"].get<double>(), r["unit"].get<std::string>());
    }
    if (summary.contains("loads")) print_coverage(summary["loads"]);
    fmt::print("results: {}/{}{}{}\n", out, fmt::join(kResults, ", "),
               summary.contains("wires") ? ", " : "", summary.contains("wires") ? kWires : "");
  }

  // Where the ground's forces are known, and where torques are not to be believed.
  static void print_coverage(const nlohmann::ordered_json& loads) {
    for (const auto& [foot, of_foot] : loads["feet"].items()) {
      fmt::print("loads of the {} foot are known in {} of {} frames: {}\n", foot,
                 of_foot["complete_frames"].get<int>(), loads["frames"].get<int>(),
                 of_foot["complete_times"].get<std::string>());
    }
    if (loads["complete_frames"] == loads["frames"]) return;
    fmt::print(
        "elsewhere torques of that leg, and residuals at the root, lack the ground's force: "
        "columns "
        "..._loads_complete of id.sto are 0 there\n");
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
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace sinew
