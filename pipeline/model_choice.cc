#include "pipeline/model_choice.h"

#include <fmt/format.h>

#include <stdexcept>

#include "model/osim_file.h"
#include "model/whole_body.h"
#include "pipeline/option_checks.h"

namespace sinew {

void ModelChoice::add_to(CLI::App& command) {
  command
      .add_option("MODEL", name,
                  "An OpenSim model (.osim), or a built-in body: whole-body or whole-body-detailed")
      ->required();
  command.add_option("--height", height, "Height of a built-in body [m]")->check(more_than_zero());
  command.add_option("--mass", mass, "Mass of a built-in body [kg]")->check(more_than_zero());
  command.add_option("--sex", sex, "Sex of a built-in body, male unless given")
      ->check(CLI::IsMember({"male", "female"}));
}

MusculoskeletalModel ModelChoice::load() const {
  std::optional<WholeBodyOptions> options = find_whole_body(name);
  if (!options) {
    if (height || mass || !sex.empty()) {
      throw std::invalid_argument(fmt::format(
          "--height, --mass and --sex are for the built-in bodies; '{}' is a file", name));
    }
    return read_osim(name);
  }
  options->height = height.value_or(options->height);
  options->mass = mass.value_or(options->mass);
  if (sex == "female") options->sex = WholeBodyOptions::Sex::kFemale;
  options->validate();
  return whole_body(*options);
}

InputFiles ModelChoice::files() const {
  if (find_whole_body(name)) return {};
  return {{"model", name}};
}

}  // namespace sinew
