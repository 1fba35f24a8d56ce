#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <new>
#include <string>
#include <vector>

#include "pipeline/command.h"
#include "pipeline/option_names.h"
#include "pipeline/version.h"

namespace {

// What is wrong, and the subcommand whose --help says what is right.
std::string usage_error(const CLI::App* app, const CLI::Error& error) {
  std::string command = app->get_name();
  for (const CLI::App* sub : app->get_subcommands()) command += " " + sub->get_name();
  // CLI11 asks for a subcommand where the name of one is misspelt.
  const std::vector<std::string> unknown = app->remaining();
  const std::string problem = app->get_subcommands().empty() && !unknown.empty()
                                  ? fmt::format("there is no subcommand '{}'", unknown.front())
                                  : error.what();
  return fmt::format("error: {}\nRun `{} --help` for usage.\n", problem, command);
}

constexpr const char* kFooter =
    "Examples:\n"
    "  sinew run                                    the embedded walk, results in ./sinew-results\n"
    "  sinew run --model m.osim --markers walk.trc --loads grf.xml --cutoff 6 --out results\n"
    "  sinew ik --setup Setup_IK.xml                an OpenSim setup as it is\n"
    "  sinew validate --model m.osim --markers walk.trc\n"
    "\n"
    "Exit codes: 0 done and usable, 1 failed or not usable (see verdict.json), 2 bad usage or bad "
    "input.\n";

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("From a gait recording to joint angles and joint torques.", "sinew");
  app.footer(kFooter);
  app.set_version_flag("--version", sinew::version());
  app.require_subcommand(1);
  app.failure_message(usage_error);
  int exit_code = sinew::kExitFailed;
  try {
    sinew::add_run_command(app, exit_code);
    sinew::add_ik_command(app, exit_code);
    sinew::add_id_command(app, exit_code);
    sinew::add_validate_command(app, exit_code);
    sinew::add_example_command(app, exit_code);
    sinew::add_compare_command(app, exit_code);
    sinew::add_bench_command(app, exit_code);
    sinew::add_check_command(app, exit_code);
    sinew::add_convert_command(app, exit_code);
    sinew::add_model_command(app, exit_code);
    sinew::add_scale_command(app, exit_code);
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? sinew::kExitOk : sinew::kExitBadInput;
  } catch (const sinew::InputError& error) {
    fmt::print(stderr, "error: {}\n", sinew::in_words_of_options(error.what()));
    return sinew::kExitBadInput;
  } catch (const std::invalid_argument& error) {
    fmt::print(stderr, "error: {}\n", sinew::in_words_of_options(error.what()));
    return sinew::kExitBadInput;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "error: not enough memory; solve a shorter time range (--from, --to)\n");
    return sinew::kExitFailed;
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return sinew::kExitFailed;
  }
  return exit_code;
}
