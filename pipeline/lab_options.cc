#include "pipeline/lab_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>

#include "data/laboratory_axes.h"
#include "model/whole_body.h"
#include "pipeline/option_checks.h"
#include "pipeline/prepare_options.h"

namespace sinew {
namespace {

constexpr const char* kGroup = "From a laboratory's files";

struct InputOption {
  const char* option;
  const char* role;  // in decisions.json
};
constexpr InputOption kInputs[] = {{"--c3d", "c3d"},     {"--static", "static"},
                                   {"--model", "model"}, {"--marker-set", "marker_set"},
                                   {"--map", "map"},     {"--scale-setup", "scale_setup"},
                                   {"--tasks", "tasks"}, {"--task-coordinates", "task_coordinates"},
                                   {"--loads", "loads"}, {"--load-data", "load_data"}};
constexpr const char* kNoDecisions[] = {"--out",   "--decisions", "--threads",
                                        "--trace", "--accept",    "--help"};

// What each option decides.
struct OptionDecision {
  const char* option;
  const char* decision;
  enum class Kind { kText, kTexts, kNames, kNumber, kFlag } kind;
};
using Kind = OptionDecision::Kind;
constexpr OptionDecision kDecisions[] = {{"--unit", "unit", Kind::kText},
                                         {"--unit", "static unit", Kind::kText},
                                         {"--swap", "swap", Kind::kTexts},
                                         {"--drop", "drop", Kind::kTexts},
                                         {"--swap-sides", "swap sides", Kind::kFlag},
                                         {"--rename", "rename", Kind::kTexts},
                                         {"--drop-samples", "drop samples", Kind::kTexts},
                                         {"--spikes", "spikes", Kind::kText},
                                         {"--spikes", "static spikes", Kind::kText},
                                         {"--force-spikes", "force spikes", Kind::kText},
                                         {"--force-spikes", "static force spikes", Kind::kText},
                                         {"--zero-plates", "zero plates", Kind::kTexts},
                                         {"--shift-forces", "shift forces", Kind::kNumber},
                                         {"--up", "up", Kind::kText},
                                         {"--up", "static up", Kind::kText},
                                         {"--forward", "forward", Kind::kText},
                                         {"--subject", "subject", Kind::kText},
                                         {"--subject", "static subject", Kind::kText},
                                         {"--mass", "mass", Kind::kNumber},
                                         {"--scale", "scaling", Kind::kText},
                                         {"--technical", "technical markers", Kind::kNames},
                                         {"--height", "height", Kind::kNumber},
                                         {"--max-gap", "max gap", Kind::kNumber},
                                         {"--fill-rigid", "fill rigid", Kind::kFlag},
                                         {"--filled-weight", "filled weight", Kind::kNumber},
                                         {"--marker-cutoff", "marker cutoff", Kind::kNumber},
                                         {"--force-cutoff", "force cutoff", Kind::kNumber},
                                         {"--cutoff", "coordinate cutoff", Kind::kNumber},
                                         {"--threshold", "threshold", Kind::kNumber},
                                         {"--posture-weight", "posture weight", Kind::kNumber},
                                         {"--posture", "posture", Kind::kText},
                                         {"--from", "from", Kind::kNumber},
                                         {"--to", "to", Kind::kNumber}};

bool is_file_option(const CLI::App& command, const std::string& name) {
  // Built-in bodies are no files.
  if (name == "--model") {
    return !find_whole_body(command.get_option("--model")->as<std::string>());
  }
  return std::any_of(std::begin(kInputs), std::end(kInputs),
                     [&](const InputOption& input) { return name == input.option; });
}

}  // namespace

void LabOptions::add_to(CLI::App& command) {
  const std::size_t others = command.get_options().size();
  command.add_option("--c3d", c3d,
                     "A trial as a laboratory records it (.c3d; .trc for markers alone): axes, "
                     "unit, names, gaps, filters, platforms and scaling are decided and explained");
  command.add_option("--static", static_trial,
                     "A trial in which the subject stands (.c3d or .trc), to scale the model by");
  command.add_option("--mass", mass, "Mass of the subject [kg]")->check(more_than_zero());
  command.add_option("--height", height, "Height of a built-in body [m]")->check(more_than_zero());
  command.add_option("--sex", sex, "Sex of a built-in body, male unless given")
      ->check(CLI::IsMember({"male", "female"}));
  command.add_option("--marker-set", marker_set,
                     "Markers to add to the model (.xml); without, those that --scale-setup names");
  command.add_option("--scale-setup", scale_setup,
                     "OpenSim ScaleTool setup to scale the model by (.xml)");
  command
      .add_option("--scale", scale,
                  "What the model is scaled by: both, static, walk, mass alone, setup or none")
      ->check(CLI::IsMember({"both", "static", "walk", "mass", "setup", "none"}));
  command.add_flag("--no-scale", no_scale, "Take the model as it is");
  command.add_option("--technical", technical,
                     "Markers A,B,... on wands and in clusters, that sit anywhere, or none; their "
                     "names (THI, TIB, Shank...) tell unless given");
  command.add_option("--map", map,
                     "Names of markers (.csv): lines `recorded,model`, the model's empty for a "
                     "marker that shall not be used");
  command.add_option("--subject", subject,
                     "Whose markers, where a trial has several: the name before the colon");
  edit.add_to(command);
  command.add_option("--up", up, "The laboratory's axis that points up, or keep to turn nothing")
      ->check(an_axis(true));
  command.add_option("--forward", forward, "The laboratory's axis along which the subject goes")
      ->check(an_axis(false));
  command.add_option("--max-gap", max_gap, "Fill gaps of markers up to this long by a spline [s]")
      ->check(zero_or_more());
  command.add_flag("--fill-rigid,!--no-fill-rigid", fill_rigid,
                   "Fill gaps from three or more markers on the same body, or do not");
  command
      .add_option("--marker-cutoff", marker_cutoff,
                  "Zero-lag low-pass of markers [Hz], negative for none")
      ->check(a_cutoff());
  command
      .add_option("--force-cutoff", force_cutoff,
                  "Zero-lag low-pass of ground forces [Hz], negative for none; as --marker-cutoff "
                  "unless given")
      ->check(a_cutoff());
  command
      .add_option("--threshold", threshold,
                  "Below this force on a platform nothing stands on it [N]")
      ->check(zero_or_more());
  command
      .add_option("--assign", assign,
                  "Say which foot stands on a platform: PLATE:FOOT or PLATE:FOOT@FROM-TO, FOOT "
                  "right, left or none; may be repeated")
      ->allow_extra_args(false);
  command
      .add_option("--attach", attach,
                  "Track a recorded marker that the model lacks on a body of the model: NAME=BODY; "
                  "may be repeated")
      ->allow_extra_args(false);
  command.add_flag("--no-attach", no_attach,
                   "Leave out markers that the model lacks, also if they keep their distances to a "
                   "segment; those that --attach names are attached all the same");
  command
      .add_option("--posture-weight", posture_weight,
                  "Draws coordinates that the markers do not determine to their defaults [1/rad²]")
      ->check(zero_or_more());
  command
      .add_option("--posture", posture,
                  "What a trunk and a head without markers do: upright, facing where the pelvis "
                  "does, or default, which goes rigidly with the pelvis")
      ->check(CLI::IsMember({"upright", "default"}));
  command.add_option("--decisions", decisions,
                     "Repeat the run that wrote this decisions.json, which may have been edited");
  const std::vector<CLI::Option*> options = command.get_options();
  for (std::size_t i = others; i < options.size(); ++i) options[i]->group(kGroup);
}

void LabOptions::require_none(const CLI::App& command) {
  std::vector<std::string> given;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_group() == kGroup && option->count() > 0) given.push_back(option->get_name());
  }
  if (given.empty()) return;
  throw std::invalid_argument(
      fmt::format("{} {} to a laboratory's trial: give it with --c3d FILE.c3d, or leave {} out",
                  fmt::join(given, ", "), given.size() == 1 ? "belongs" : "belong",
                  given.size() == 1 ? "it" : "them"));
}

void LabOptions::validate() const {
  if (no_scale && !scale_setup.empty()) {
    throw std::invalid_argument("--no-scale and --scale-setup contradict each other: give one");
  }
  if (no_scale && mass) {
    throw std::invalid_argument(
        "--no-scale takes the model's masses as they are: leave --mass out, or --no-scale");
  }
}

std::set<std::string> take_replayed_options(CLI::App& command, const DecisionLog& log) {
  std::set<std::string> now;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() > 0) now.insert(option->get_name());
  }
  const auto take = [&](const std::string& name, const std::vector<std::string>& values) {
    CLI::Option* const option = command.get_option_no_throw(name);
    if (option == nullptr || now.contains(name)) return;
    option->add_result(values);
    option->run_callback();
  };
  for (const auto& [name, values] : log.options()) take(name, values);
  for (const auto& [option, role] : kInputs) {
    const auto found = log.inputs().find(role);
    if (found != log.inputs().end()) take(option, {found->second.string()});
  }
  return now;
}

void say_options(const CLI::App& command, const std::set<std::string>& now, DecisionLog& log) {
  for (const auto& [name, decision, kind] : kDecisions) {
    const CLI::Option* const option = command.get_option(name);
    if (option->count() == 0) continue;
    const bool is_now = now.contains(name);
    // `auto` asks for what is found.
    if (kind == Kind::kText && option->as<std::string>() != "auto") {
      log.say(decision, option->as<std::string>(), is_now);
    } else if (kind == Kind::kTexts) {
      log.say(decision, option->as<std::vector<std::string>>(), is_now);
    } else if (kind == Kind::kNames) {
      log.say(decision, split_names(option->as<std::string>()), is_now);
    } else if (kind == Kind::kNumber) {
      log.say(decision, option->as<double>(), is_now);
    } else if (kind == Kind::kFlag) {
      log.say(decision, option->as<bool>(), is_now);
    }
  }
}

nlohmann::ordered_json given_options(const CLI::App& command) {
  nlohmann::ordered_json options = nlohmann::ordered_json::object();
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    if (option->count() == 0 || is_file_option(command, name)) continue;
    if (std::find(std::begin(kNoDecisions), std::end(kNoDecisions), name) !=
        std::end(kNoDecisions)) {
      continue;
    }
    options[name] = option->results();
  }
  return options;
}

}  // namespace sinew
