#include <fmt/format.h>

#include "data/output_file.h"
#include "data/storage_file.h"
#include "pipeline/command.h"
#include "pipeline/ik_job.h"
#include "pipeline/ik_options.h"
#include "pipeline/output_check.h"
#include "pipeline/reports.h"
#include "pipeline/trace.h"
#include "pipeline/undetermined.h"
#include "pipeline/verdict_evidence.h"
#include "pipeline/verdict_report.h"
#include "pipeline/wire_report.h"

namespace sinew {
namespace {

struct IkCommand {
  std::string setup;
  IkOptions options;
  std::string out, wire_table;
  bool accept = false;

  int run() const {
    IkInputs inputs = options.inputs();
    std::filesystem::path output = out;
    std::vector<Warning> warnings;
    if (!setup.empty()) {
      const IkSetup tool = read_ik_setup(setup);
      report(warnings, tool.warnings);
      merge(tool, inputs);
      if (output.empty() && !tool.output_motion_file.empty()) {
        output = tool.output_motion_file;
        require_own_path(output, location_of(tool, "output_motion_file"), "output_motion_file");
      }
    }
    options.require_files(inputs);
    if (output.empty()) {
      throw std::invalid_argument(
          "no output file: give --out FILE, or name <output_motion_file> in the setup");
    }
    InputFiles files = input_files(inputs);
    files.emplace_back("setup", setup);
    check_outputs({output, verdict_path(output), options.trace, wire_table}, files);
    IkJob job = prepare_ik(inputs);
    report(warnings, job.warnings);
    const std::optional<TrackingResult> result = solve_ik(job);
    if (!result) return kExitFailed;
    const std::vector<VerdictReason> findings = tracking_findings(job, *result);
    TimeTable motion = coordinate_motion(job.model, *result);
    set_undetermined(undetermined_names(findings), motion);
    write_storage(output, motion);
    if (!options.trace.empty()) {
      write_file_atomically(options.trace, trace_csv(*result, job.options.first_frame));
    }
    if (!wire_table.empty()) {
      write_file_atomically(wire_table, wires_csv(job.model, job.tracking, *result));
    }
    const Verdict verdict = judge(gather(job, *result, findings));
    write_verdict(verdict_path(output), verdict);
    report(warnings, frame_warnings(*result, job.recording.path));
    fmt::print("{} frames in {:.3g} s ({:.3g} ms a frame), marker RMS {:.2f} mm\n{}{}\n",
               result->frames.size(), result->seconds,
               1e3 * result->seconds / static_cast<double>(result->frames.size()),
               1e3 * total_marker_rms(*result), verdict_text(verdict, kMostLines - 2),
               output.string());
    return exit_code(verdict, accept);
  }

  static VerdictEvidence gather(const IkJob& job, const TrackingResult& result,
                                std::vector<VerdictReason> findings) {
    VerdictEvidence evidence;
    evidence.joints = joint_evidence(job.model);
    evidence.angles = true;
    evidence.model = model_evidence(job.model);
    evidence.found = std::move(findings);
    evidence.kinematics = kinematics_evidence(job, result, kNaN, evidence.found);
    return evidence;
  }
};

}  // namespace

void add_ik_command(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<IkCommand>();
  CLI::App* sub = app.add_subcommand("ik", "Markers to joint angles");
  sub->add_option("--setup", command->setup,
                  "OpenSim InverseKinematicsTool setup; options given here "
                  "take precedence over it");
  command->options.add_to(*sub);
  sub->add_option("--out", command->out, "Motion file to write (.mot), angles in degrees");
  sub->add_option("--wire-table", command->wire_table,
                  "Write places of virtual links and lengths, slack and strain of wires (.csv)");
  sub->add_flag("--accept", command->accept, kAcceptHelp);
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace sinew
