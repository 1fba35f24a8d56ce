#include <fmt/format.h>

#include <chrono>

#include "data/output_file.h"
#include "data/storage_file.h"
#include "pipeline/command.h"
#include "pipeline/example.h"
#include "pipeline/id_job.h"
#include "pipeline/ik_job.h"
#include "pipeline/ik_options.h"
#include "pipeline/reports.h"
#include "pipeline/version.h"

namespace sinew {
namespace {

struct RunCommand {
  IkOptions ik;
  std::string loads, load_data, out = "sinew-results";
  double cutoff = kDefaultCutoff;
  bool project_couplers = false;

  // Without any file the embedded walk is written to the output folder and run from there.
  void use_example() {
    const std::filesystem::path folder = std::filesystem::path(out) / "example";
    write_example(folder);
    fmt::print("no model given: running the embedded walk, written to {}\n", folder.string());
    ik.model = (folder / "model.osim").string();
    ik.markers = (folder / "walk.trc").string();
    ik.tasks = (folder / "ik_tasks.xml").string();
    loads = (folder / "grf.xml").string();
  }

  int run() {
    const auto start = std::chrono::steady_clock::now();
    if (ik.model.empty() && ik.markers.empty()) use_example();
    const IkInputs inputs = ik.inputs();
    ik.require_files(inputs);
    IkJob job = prepare_ik(inputs);
    std::vector<Warning> warnings = job.warnings;
    std::filesystem::path data = load_data;
    const ExternalLoads external = read_loads(job.model, loads, data, warnings);

    watch_interrupts();
    job.options.progress = progress_bar("inverse kinematics");
    const TrackingResult solved =
        track(job.model, job.tree, job.tracking, job.recording.markers, job.options);
    if (solved.stopped) {
      fmt::print(stderr, "stopped; no results were written\n");
      return kExitFailed;
    }
    InverseDynamicsOptions options;
    options.cutoff = cutoff;
    options.project_couplers = project_couplers;
    options.threads = ik.threads;
    const auto id_start = std::chrono::steady_clock::now();
    const SimbodyModel compiled(job.model);
    const InverseDynamicsResult torques = inverse_dynamics(
        job.model, compiled, coordinate_table(job.model, solved), external, options);
    warnings.insert(warnings.end(), torques.warnings.begin(), torques.warnings.end());
    print_warnings(warnings);

    nlohmann::ordered_json summary;
    summary["versions"] = component_versions();
    summary["inputs"] = input_summary({{"model", inputs.model_file},
                                       {"markers", inputs.marker_file},
                                       {"tasks", ik.tasks},
                                       {"task_coordinates", inputs.coordinate_file},
                                       {"loads", loads},
                                       {"load_data", data}});
    summary["options"] = {
        {"method", inputs.method},  {"gradient_tolerance", inputs.tolerance},
        {"cutoff_hz", cutoff},      {"project_couplers", project_couplers},
        {"from_s", solved.time[0]}, {"to_s", solved.time[solved.time.size() - 1]}};
    summary["inverse_kinematics"] = ik_summary(job.tracking, solved, job.options);
    summary["inverse_dynamics"] = id_summary(job.model, torques.forces);
    summary["inverse_dynamics"]["seconds"] = seconds_since(id_start);
    summary["warnings"] = warning_summary(warnings);
    summary["seconds"] = seconds_since(start);
    write_results(job, solved, torques.forces, summary);
    print_digest(solved, summary);
    return unconverged_frames(solved) == 0 ? kExitOk : kExitFailed;
  }

  static double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  void write_results(const IkJob& job, const TrackingResult& solved, const TimeTable& torques,
                     const nlohmann::ordered_json& summary) const {
    const std::filesystem::path folder = out;
    write_storage(folder / "ik.mot", coordinate_motion(job.model, solved));
    write_storage(folder / "id.sto", torques);
    write_file_atomically(folder / "marker_errors.csv",
                          marker_errors_csv(marker_errors(job.tracking, solved)));
    write_file_atomically(folder / "frame_errors.csv", frame_errors_csv(job.tracking, solved));
    write_file_atomically(folder / "summary.json", summary.dump(2) + "\n");
  }

  void print_digest(const TrackingResult& solved, const nlohmann::ordered_json& summary) const {
    const auto& kinematics = summary["inverse_kinematics"];
    fmt::print("inverse kinematics: {} frames, {:.3g} ms a frame, marker RMS {:.2f} mm",
               solved.frames.size(), kinematics["ms_per_frame"].get<double>(),
               1e3 * total_marker_rms(solved));
    if (kinematics.contains("worst_marker")) {
      fmt::print(", worst marker {} ({:.1f} mm)",
                 kinematics["worst_marker"]["name"].get<std::string>(),
                 1e3 * kinematics["worst_marker"]["rms_m"].get<double>());
    }
    fmt::print("\ninverse dynamics: coordinates {}; residuals at the root:\n",
               cutoff > 0.0 ? fmt::format("low-passed at {} Hz", cutoff) : "not filtered");
    for (const auto& r : summary["inverse_dynamics"]["root_residuals"]) {
      fmt::print("  {:<28} RMS {:8.2f} max {:8.2f} {}\n", r["column"].get<std::string>(),
                 r["rms"].get<double>(), r["max"].get<double>(), r["unit"].get<std::string>());
    }
    if (const int bad = unconverged_frames(solved); bad > 0) {
      fmt::print(stderr, "warning: {} frames did not converge\n", bad);
    }
    fmt::print("results: {}/ik.mot, id.sto, marker_errors.csv, frame_errors.csv, summary.json\n",
               out);
  }
};

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<RunCommand>();
  CLI::App* sub = app.add_subcommand(
      "run",
      "Markers and ground forces to joint angles and joint torques; without files, the "
      "embedded walk");
  command->ik.add_to(*sub);
  sub->add_option("--loads", command->loads, "OpenSim ExternalLoads (.xml)");
  sub->add_option("--load-data", command->load_data,
                  "Force data (.mot or .sto) instead of the one that --loads names");
  sub->add_option(
         "--cutoff", command->cutoff,
         "Zero-lag low-pass of the coordinates before they are differentiated [Hz]; negative "
         "for none")
      ->capture_default_str();
  sub->add_flag("--project-couplers", command->project_couplers,
                "Fold the forces of coupled coordinates onto the coordinates that drive them");
  sub->add_option("--out", command->out, "Folder for the results")->capture_default_str();
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace sinew
