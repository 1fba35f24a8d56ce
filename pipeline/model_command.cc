#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string_view>

#include "data/output_file.h"
#include "model/furcation.h"
#include "model/osim_writer.h"
#include "pipeline/command.h"
#include "pipeline/model_choice.h"
#include "pipeline/model_report.h"
#include "pipeline/option_checks.h"

namespace sinew {
namespace {

struct InfoCommand {
  ModelChoice choice;
  std::string coordinate;  // of the moment arms; empty: none
  int points = 7;
  bool json = false;

  int run() const {
    const MusculoskeletalModel model = choice.load();
    std::vector<Warning> warnings;
    report(warnings, model.warnings);
    const ModelSummary summary = summarize(model);
    std::optional<MomentArmTable> table;
    if (!coordinate.empty()) table = moment_arm_table(model, coordinate, points);
    if (json) {
      nlohmann::ordered_json out = info_json(model, summary);
      if (table) out["moment_arms"] = moment_arm_json(model, *table);
      fmt::print("{}\n", out.dump(2));
      return kExitOk;
    }
    fmt::print("{}", info_text(model, summary));
    if (table) fmt::print("{}", moment_arm_text(model, *table));
    return kExitOk;
  }
};

struct CheckCommand {
  ModelChoice choice;
  ModelCheckOptions options;
  bool json = false;

  int run() const {
    const MusculoskeletalModel model = choice.load();
    const std::vector<ModelFinding> findings = check_model(model, options);
    if (json) {
      fmt::print("{}\n", findings_json(findings).dump(2));
    } else {
      fmt::print("{}", findings_text(findings));
    }
    const bool errors = count(findings, ModelFinding::Severity::kError) > 0;
    return errors ? kExitFailed : kExitOk;
  }
};

struct ExportCommand {
  ModelChoice choice;
  std::string out;

  int run() const {
    check_outputs({out}, choice.files());
    const MusculoskeletalModel model = choice.load();
    std::vector<Warning> warnings;
    report(warnings, model.warnings);
    report(warnings, losses_of_osim(model));
    write_file_atomically(out, write_osim(model));
    fmt::print("{}\n", out);
    return kExitOk;
  }
};

// a,b,c:NAME or a,b,c
FurcationRequest parse_request(const std::string& text) {
  FurcationRequest request;
  const std::size_t colon = text.find(':');
  if (colon != std::string::npos) request.name = text.substr(colon + 1);
  std::string_view muscles = std::string_view(text).substr(0, colon);
  while (!muscles.empty()) {
    const std::size_t comma = std::min(muscles.find(','), muscles.size());
    request.muscles.emplace_back(muscles.substr(0, comma));
    muscles.remove_prefix(std::min(comma + 1, muscles.size()));
  }
  return request;
}

struct FurcateCommand {
  ModelChoice choice;
  FurcationOptions options;
  std::vector<std::string> muscles;
  std::string out;

  int run() {
    for (const std::string& text : muscles) options.requests.push_back(parse_request(text));
    options.validate();
    check_outputs({out}, choice.files());
    const MusculoskeletalModel model = choice.load();
    std::vector<Warning> warnings;
    report(warnings, model.warnings);
    const FurcatedModel furcated = furcate(model, options);
    report(warnings, furcated.warnings);
    report(warnings, losses_of_osim(furcated.model));
    if (furcated.furcations.empty()) {
      fmt::print(stderr,
                 "error: no two muscles end within {:g} m of each other on one bone; nothing was "
                 "written. Allow a larger --distance.\n",
                 options.distance);
      return kExitFailed;
    }
    write_file_atomically(out, write_osim(furcated.model));
    fmt::print("{}{}\n", furcations_text(furcated.furcations), out);
    return kExitOk;
  }
};

void add_info(CLI::App& parent, int& exit_code) {
  auto command = std::make_shared<InfoCommand>();
  CLI::App* sub = parent.add_subcommand(
      "info", "Counts, masses, the tree of joints and the paths that cross each, moment arms");
  command->choice.add_to(*sub);
  sub->add_option("--moment-arms", command->coordinate,
                  "Also the moment arms of all paths about this coordinate, over its range");
  sub->add_option("--points", command->points, "Values of the coordinate to take")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
  sub->add_flag("--json", command->json, "Print JSON, in SI units and radians");
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

void add_check(CLI::App& parent, int& exit_code) {
  auto command = std::make_shared<CheckCommand>();
  CLI::App* sub = parent.add_subcommand(
      "check", "Looks for what the model's author may not have meant; fails where it finds errors");
  command->choice.add_to(*sub);
  sub->add_option("--mirror-tolerance", command->options.mirror_tolerance,
                  "Between left and right places [m]")
      ->check(more_than_zero())
      ->capture_default_str();
  sub->add_option("--relative-tolerance", command->options.relative_tolerance,
                  "Between left and right masses, inertias, forces and lengths")
      ->check(more_than_zero())
      ->capture_default_str();
  sub->add_option("--plausible-distance", command->options.plausible_distance,
                  "From a point to anything else on its bone [m]")
      ->check(more_than_zero())
      ->capture_default_str();
  sub->add_flag("--json", command->json, "Print JSON");
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

void add_export(CLI::App& parent, int& exit_code) {
  auto command = std::make_shared<ExportCommand>();
  CLI::App* sub = parent.add_subcommand("export", "Writes the model for OpenSim 4");
  command->choice.add_to(*sub);
  sub->add_option("--out", command->out, "File to write (.osim)")->required();
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

void add_furcate(CLI::App& parent, int& exit_code) {
  auto command = std::make_shared<FurcateCommand>();
  CLI::App* sub = parent.add_subcommand(
      "furcate", "Joins muscles that end at one place of a bone by a virtual link and one tendon");
  command->choice.add_to(*sub);
  sub->add_option("--out", command->out, "File to write (.osim)")->required();
  sub->add_option("--distance", command->options.distance,
                  "Ends within this of each other are one place [m]")
      ->check(zero_or_more())
      ->capture_default_str();
  sub->add_option("--muscles", command->muscles,
                  "Only these: a,b,c or a,b,c:NAME to name the virtual link; may be repeated");
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace

void add_model_command(CLI::App& app, int& exit_code) {
  CLI::App* model = app.add_subcommand("model", "Looks at, checks, writes and furcates models");
  model->require_subcommand(1);
  add_info(*model, exit_code);
  add_check(*model, exit_code);
  add_export(*model, exit_code);
  add_furcate(*model, exit_code);
}

}  // namespace sinew
