#include <fmt/format.h>

#include <memory>
#include <stdexcept>

#include "data/force_table.h"
#include "model/osim_file.h"
#include "pipeline/command.h"
#include "pipeline/conversion.h"
#include "pipeline/ground_reaction.h"
#include "pipeline/lab_trial.h"
#include "pipeline/option_checks.h"
#include "pipeline/output_check.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

struct ConvertCommand {
  std::vector<std::string> inputs;
  std::string out, format, loads, model;
  std::vector<std::string> assign;
  Conversion conversion;

  int run() {
    if (out.empty()) throw std::invalid_argument("no output: give --out FILE");
    InputFiles files;
    for (const std::string& input : inputs) files.emplace_back("input", input);
    files.emplace_back("segments", conversion.prepare.segments_from);
    check_events();
    if (!loads.empty() || !assign.empty()) {
      files.emplace_back("model", model);
      check_outputs({out, loads, contacts_path(out)}, files);
      assign_loads();
    } else if (inputs.size() == 1 && format.empty()) {
      check_outputs({out, conversion.filled_path(out)}, files);
      conversion.convert(inputs.front(), out);
    } else if (format.empty() && format_of(out) == Format::kC3d) {
      check_outputs({out, conversion.filled_path(out)}, files);
      conversion.merge(inputs, out);
    } else {
      convert_all(files);
    }
    return kExitOk;
  }

  void check_events() const {
    const bool one = inputs.size() == 1 && format.empty() && loads.empty();
    if (conversion.events.empty() ||
        (one && format_of(inputs.front()) == Format::kC3d && format_of(out) == Format::kC3d)) {
      return;
    }
    throw std::invalid_argument(
        "--events goes from one C3D file into another: give FILE.c3d --out NEW.c3d, or --what "
        "events --out NAME.csv");
  }

  // Each input into a file of its name in the folder --out.
  void convert_all(const InputFiles& files) {
    if (format.empty()) {
      throw std::invalid_argument(
          "several inputs become one file only if that is a C3D file: give --out FILE.c3d, or "
          "--format trc and a folder as --out");
    }
    std::vector<fs::path> outputs;
    for (const std::string& input : inputs) {
      outputs.push_back(fs::path(out) / (fs::path(input).stem().string() + "." + format));
    }
    check_outputs(outputs, files);
    for (std::size_t i = 0; i < inputs.size(); ++i) conversion.convert(inputs[i], outputs[i]);
  }

  // Which foot stands where, and the loads of each foot for inverse dynamics.
  void assign_loads() {
    const bool to_motion = inputs.size() == 1 && format_of(inputs.front()) == Format::kC3d &&
                           format.empty() &&
                           (format_of(out) == Format::kMot || format_of(out) == Format::kSto);
    if (!to_motion || loads.empty()) {
      throw std::invalid_argument(
          "feet are assigned to the platforms of one C3D file: give FILE.c3d --out GRF.mot --loads "
          "GRF.xml");
    }
    const std::vector<AssignmentOverride> overrides = parse_overrides(assign);
    const PrepareOptions& prepare = conversion.prepare;
    LabTrial trial = read_lab_trial(inputs.front(), prepare, conversion.warnings);
    require_c3d_part(trial.file, !force_table(trial.plates).labels.empty(),
                     "force platform that can be used");
    std::optional<MusculoskeletalModel> description;
    if (!model.empty()) description = read_osim(model);
    condition_plates(trial.plates, prepare);
    const FootAssignment assignment =
        assign_trial(trial, description ? &*description : nullptr, prepare.threshold, overrides);
    const TimeTable table =
        conversion.cropped(foot_loads(assignment, trial.plates), trial.file.path);
    write_ground_reactions(assignment, trial.plates, table, out, loads);
    fmt::print("{}, {}, {}\n", out, loads, contacts_path(out).string());
  }
};

}  // namespace

void add_convert_command(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<ConvertCommand>();
  CLI::App* sub = app.add_subcommand(
      "convert",
      "Recordings between C3D, TRC, MOT, STO and CSV; rotated, cropped, filled, filtered");
  sub->add_option("inputs", command->inputs, fmt::format("Recordings ({})", kRecordingFormats))
      ->required();
  sub->add_option("--out", command->out,
                  "File to write; several tables and one recording of markers go into one C3D "
                  "file; with --format a folder");
  sub->add_option("--format", command->format, "Write every input as c3d, trc, mot, sto or csv")
      ->check(CLI::IsMember({"c3d", "trc", "mot", "sto", "csv"}));
  sub->add_option("--what", command->conversion.what,
                  "Part of a C3D file: markers (of .trc and .csv unless given), forces (of .mot), "
                  "analog (of .sto), computed; or events, the heel strikes and toe offs by forces, "
                  "the file and markers, into a .csv file")
      ->check(CLI::IsMember({"markers", "forces", "analog", "computed", "events"}));
  sub->add_option("--events", command->conversion.events,
                  "Write heel strikes and toe offs into a C3D file in place of its own: by forces, "
                  "by kinematics, or all")
      ->check(CLI::IsMember({"forces", "kinematics", "all"}));
  sub->add_option("--loads", command->loads,
                  "Assign feet to a C3D file's platforms: --out gets the feet's loads (.mot), this "
                  "file the ExternalLoads (.xml) that `sinew id` and OpenSim read");
  sub->add_option("--assign", command->assign,
                  "Say which foot stands on a platform: PLATE:FOOT or PLATE:FOOT@FROM-TO, FOOT "
                  "right, left or none; may be repeated")
      ->allow_extra_args(false);
  sub->add_option(
      "--model", command->model,
      "Model (.osim) whose foot markers and bodies the loads are for; without, names of "
      "markers tell, and the bodies are calcn_r and calcn_l");
  sub->add_option("--from", command->conversion.from, "First time to write [s]")->check(a_time());
  sub->add_option("--to", command->conversion.to, "Last time to write [s]")->check(a_time());
  sub->add_flag("--integers", command->conversion.integers, "Write C3D numbers as 16-bit integers");
  command->conversion.prepare.add_to(*sub);
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace sinew
