#include <fmt/format.h>

#include "pipeline/command.h"
#include "pipeline/example.h"

namespace sinew {

void add_example_command(CLI::App& app, int& exit_code) {
  auto folder = std::make_shared<std::string>("sinew-example");
  CLI::App* sub = app.add_subcommand(
      "example", "Writes the embedded walk as files: model, markers, forces, setups and the truth");
  sub->add_option("--out", *folder, "Folder to write to")->capture_default_str();
  sub->callback([folder, &exit_code] {
    write_example(*folder);
    fmt::print("{}\n", *folder);
    exit_code = kExitOk;
  });
}

}  // namespace sinew
