#include <fmt/format.h>

#include <memory>
#include <stdexcept>

#include "data/numbers.h"
#include "data/output_file.h"
#include "data/preflight_gaps.h"
#include "pipeline/check_report.h"
#include "pipeline/command.h"
#include "pipeline/gait_event_options.h"
#include "pipeline/option_checks.h"
#include "pipeline/output_check.h"
#include "pipeline/preflight.h"
#include "pipeline/preflight_files.h"
#include "pipeline/recording.h"
#include "pipeline/version.h"

namespace sinew {
namespace {

struct CheckCommand {
  std::vector<std::string> files;
  std::string model, static_trial, json, events;
  double threshold = kContactForce;  // [N]

  int run() {
    InputFiles inputs;
    for (const std::string& file : files) inputs.emplace_back("input", file);
    inputs.emplace_back("static", static_trial);
    inputs.emplace_back("model", model);
    check_outputs({json, events}, inputs);
    PreflightFiles read;
    if (!model.empty()) read.read_model(model);
    const auto progress = progress_bar("reading");
    for (std::size_t i = 0; i < files.size(); ++i) {
      read.read(files[i]);
      progress(static_cast<int>(i) + 1, static_cast<int>(files.size()));
    }
    if (!static_trial.empty()) read.read(static_trial);
    PreflightInputs preflight = read.inputs();
    if (!static_trial.empty()) preflight.standing = find_recording(preflight, static_trial);
    preflight.threshold = threshold;
    std::vector<Finding> findings = read.findings();
    for (Finding& finding : run_preflight(preflight)) findings.push_back(std::move(finding));
    print(read, findings);
    if (!json.empty()) write(read, preflight, findings);
    if (!events.empty()) write_events(preflight);
    return count(findings).errors > 0 ? kExitFailed : kExitOk;
  }

  static int find_recording(const PreflightInputs& inputs, const std::string& path) {
    for (std::size_t i = inputs.recordings.size(); i-- > 0;) {
      if (inputs.recordings[i].path == path) return static_cast<int>(i);
    }
    return -1;  // cannot be read, which is a finding already
  }

  void print(const PreflightFiles& read, const std::vector<Finding>& findings) const {
    for (const std::string& path : read.paths()) {
      const std::string what = read.describe(path);
      fmt::print("{}{}{}\n{}", path, what.empty() ? "" : ": ", what, findings_text(findings, path));
    }
    const FindingCounts counts = count(findings);
    fmt::print("{} errors, {} warnings, {} notes\n", counts.errors, counts.warnings, counts.notes);
  }

  void write_events(const PreflightInputs& inputs) const {
    std::vector<const PreflightRecording*> walks;
    for (const PreflightRecording& recording : inputs.recordings) {
      if (recording.markers) walks.push_back(&recording);
    }
    if (walks.size() != 1) {
      throw std::invalid_argument(fmt::format(
          "--events writes the events of one recording of markers; there are {}", walks.size()));
    }
    const PreflightRecording& walk = *walks.front();
    const std::vector<GaitEvent> found =
        walk.c3d ? find_gait_events(*walk.c3d,
                                    compute_forces(*walk.c3d, {.threshold = threshold}).recordings)
                 : find_gait_events(*walk.markers);
    write_file_atomically(events, events_csv(found, *walk.markers));
  }

  void write(const PreflightFiles& read, const PreflightInputs& inputs,
             const std::vector<Finding>& findings) const {
    nlohmann::ordered_json document;
    document["sinew"] = version();
    document["files"] = nlohmann::ordered_json::array();
    for (const std::string& path : read.paths()) {
      document["files"].push_back({{"path", path}, {"what", read.describe(path)}});
    }
    const FindingCounts counts = count(findings);
    document["errors"] = counts.errors;
    document["warnings"] = counts.warnings;
    document["notes"] = counts.notes;
    document["findings"] = findings_json(findings);
    document["gaps"] = gaps_json(inputs);
    write_file_atomically(json, document.dump(2) + "\n");
  }

  // Every gap between measured samples, longest first.
  static nlohmann::ordered_json gaps_json(const PreflightInputs& inputs) {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const PreflightRecording& recording : inputs.recordings) {
      if (!recording.markers) continue;
      const MarkerTrajectories& markers = *recording.markers;
      for (const MarkerGap& gap : find_inner_gaps(markers)) {
        all.push_back({{"file", recording.path},
                       {"marker", markers.names[static_cast<std::size_t>(gap.marker)]},
                       {"first_frame", markers.frame_numbers[static_cast<std::size_t>(gap.first)]},
                       {"frames", gap.count},
                       {"from", markers.time[gap.first]},
                       {"to", markers.time[gap.first + gap.count - 1]}});
      }
    }
    return all;
  }
};

}  // namespace

void add_check_command(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<CheckCommand>();
  CLI::App* sub = app.add_subcommand(
      "check", "What is wrong with recordings, models and setups, and what mends it");
  sub->add_option("files", command->files,
                  fmt::format("{}, .osim or .xml files", kRecordingFormats))
      ->required();
  sub->add_option("--model", command->model, "Model (.osim) that the markers are held against");
  sub->add_option("--static", command->static_trial,
                  "The trial in which the subject stands, held against the others: whether it is "
                  "static, and of the same person");
  sub->add_option("--json", command->json, "Write all findings to this file, for programs");
  sub->add_option("--events", command->events,
                  "Write heel strikes and toe offs, by forces, the file and markers, to this file "
                  "(.csv)");
  sub->add_option("--threshold", command->threshold,
                  "Below this force on a platform nothing stands on it [N]")
      ->check(zero_or_more())
      ->capture_default_str();
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace sinew
