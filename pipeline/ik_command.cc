#include <fmt/format.h>

#include <algorithm>

#include "data/storage_file.h"
#include "pipeline/command.h"
#include "pipeline/ik_job.h"
#include "pipeline/ik_options.h"
#include "pipeline/reports.h"

namespace sinew {
namespace {

struct IkCommand {
  std::string setup;
  IkOptions options;
  std::string out;

  int run() const {
    IkInputs inputs = options.inputs();
    std::filesystem::path output = out;
    std::vector<Warning> warnings;
    if (!setup.empty()) {
      const IkSetup tool = read_ik_setup(setup);
      warnings = tool.warnings;
      merge(tool, options, inputs);
      if (output.empty()) output = tool.output_motion_file;
    }
    options.require_files(inputs);
    if (output.empty()) {
      throw std::invalid_argument(
          "no output file: give --out FILE, or name <output_motion_file> in the setup");
    }
    IkJob job = prepare_ik(inputs);
    warnings.insert(warnings.end(), job.warnings.begin(), job.warnings.end());
    print_warnings(warnings);
    watch_interrupts();
    job.options.progress = progress_bar("inverse kinematics");
    const TrackingResult result =
        track(job.model, job.tree, job.tracking, job.recording.markers, job.options);
    if (result.stopped) {
      fmt::print(stderr, "stopped; nothing was written\n");
      return kExitFailed;
    }
    write_storage(output, coordinate_motion(job.model, result));
    fmt::print("{} frames in {:.3g} s ({:.3g} ms a frame), marker RMS {:.2f} mm\n{}\n",
               result.frames.size(), result.seconds,
               1e3 * result.seconds / static_cast<double>(result.frames.size()),
               1e3 * total_marker_rms(result), output.string());
    if (const int bad = unconverged_frames(result); bad > 0) {
      fmt::print(stderr, "warning: {} frames did not converge\n", bad);
      return kExitFailed;
    }
    return kExitOk;
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
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace sinew
