#include <fmt/format.h>

#include "pipeline/command.h"
#include "pipeline/example.h"
#include "pipeline/option_checks.h"

namespace sinew {
namespace {

struct ExampleCommand {
  std::string folder = "sinew-example", level = "detailed";
  ExampleOptions options;

  void add_to(CLI::App& command) {
    command.add_option("--out", folder, "Folder to write to")->capture_default_str();
    command
        .add_option("--level", level,
                    "How finely the body is strung: simplified, or detailed with virtual links")
        ->check(CLI::IsMember({"simplified", "detailed"}))
        ->capture_default_str();
    command.add_option("--strides", options.recording.strides, "How long to walk")
        ->check(more_than_zero())
        ->capture_default_str();
    MarkerArtifacts& artifacts = options.recording.artifacts;
    command.add_option("--noise", artifacts.noise, "Noise of the markers [m], standard deviation")
        ->check(zero_or_more())
        ->capture_default_str();
    command
        .add_option("--soft-tissue", artifacts.soft_tissue,
                    "How far skin carries markers of the shank over the bone [m], RMS; twice as "
                    "far on the thigh, half as far elsewhere")
        ->check(zero_or_more())
        ->capture_default_str();
    command.add_option("--occlusion", artifacts.occlusion, "Part of the markers' samples to lose")
        ->check(CLI::Range(0.0, 0.99))
        ->capture_default_str();
    command
        .add_option("--mislabels", artifacts.mislabels,
                    "How many times two markers exchange their names for 0.2 s")
        ->check(CLI::Range(0, 1000))
        ->capture_default_str();
    command.add_option("--seed", artifacts.seed, "Of all that is random")->capture_default_str();
  }

  int run() {
    options.body.level = level == "detailed" ? WholeBodyOptions::Level::kDetailed
                                             : WholeBodyOptions::Level::kSimplified;
    std::vector<Warning> warnings;
    report(warnings, write_example(folder, options));
    fmt::print("{}\n", folder);
    return kExitOk;
  }
};

}  // namespace

void add_example_command(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<ExampleCommand>();
  CLI::App* sub = app.add_subcommand(
      "example", "Writes the embedded walk as files: model, markers, forces, setups and the truth");
  command->add_to(*sub);
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace sinew
