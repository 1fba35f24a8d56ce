#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>

#include "pipeline/command.h"
#include "pipeline/version.h"

namespace {

constexpr const char* kFooter =
    "Examples:\n"
    "  sinew run                                    the embedded walk, results in ./sinew-results\n"
    "  sinew run --model m.osim --markers walk.trc --loads grf.xml --cutoff 6 --out results\n"
    "  sinew ik --setup Setup_IK.xml                an OpenSim setup as it is\n"
    "  sinew validate --model m.osim --markers walk.trc\n"
    "\n"
    "Exit codes: 0 done, 1 failed, 2 bad usage or bad input.\n";

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("From a gait recording to joint angles and joint torques.", "sinew");
  app.footer(kFooter);
  app.set_version_flag("--version", sinew::version());
  app.require_subcommand(1);
  int exit_code = sinew::kExitFailed;
  try {
    sinew::add_run_command(app, exit_code);
    sinew::add_ik_command(app, exit_code);
    sinew::add_id_command(app, exit_code);
    sinew::add_validate_command(app, exit_code);
    sinew::add_example_command(app, exit_code);
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? sinew::kExitOk : sinew::kExitBadInput;
  } catch (const sinew::InputError& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return sinew::kExitBadInput;
  } catch (const std::invalid_argument& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return sinew::kExitBadInput;
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return sinew::kExitFailed;
  }
  return exit_code;
}
