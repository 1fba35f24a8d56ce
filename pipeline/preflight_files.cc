#include "pipeline/preflight_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "data/c3d_reader.h"
#include "data/csv_file.h"
#include "data/marker_table.h"
#include "data/storage_file.h"
#include "data/text.h"
#include "data/trc_description.h"
#include "data/trc_file.h"
#include "model/model_check.h"
#include "model/osim_file.h"
#include "pipeline/recording.h"
#include "pipeline/setup_check.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

Finding of_input_error(const std::string& path, const InputError& error) {
  Finding finding;
  finding.severity = Finding::Severity::kError;
  finding.kind = "reading";
  finding.file = path;
  if (error.where().line > 0) finding.where = fmt::format("line {}", error.where().line);
  const InputError::Parts& parts = error.parts();
  finding.text = parts.problem;
  if (!parts.expected.empty()) finding.text += "; expected " + parts.expected;
  if (!parts.found.empty()) finding.text += ", found " + parts.found;
  finding.advice = parts.remedy;
  finding.confidence = 1.0;
  return finding;
}

Finding of_model_finding(const std::string& path, const ModelFinding& found) {
  Finding finding;
  // A model's notes are many and matter to its author: `sinew model check` tells them.
  finding.severity = found.severity == ModelFinding::Severity::kError ? Finding::Severity::kError
                                                                      : Finding::Severity::kWarning;
  finding.kind = "model";
  finding.file = path;
  finding.where = found.element;
  finding.text = found.kind + ": " + found.text;
  finding.confidence = 0.9;
  return finding;
}

bool is_model(const std::string& path) {
  return text::lower(fs::path(path).extension().string()) == ".osim";
}

bool is_setup(const std::string& path) {
  return text::lower(fs::path(path).extension().string()) == ".xml";
}

}  // namespace

void PreflightFiles::read(const std::string& path, const RecordingEdits& edits) {
  std::error_code error;
  if (!fs::exists(path, error)) {
    throw InputError({path}, {"there is no such file", "", "", "Check the path."});
  }
  if (!is_model(path) && !is_setup(path)) format_of(path);
  paths_.push_back(path);
  try {
    if (is_model(path)) {
      keep_model(path, false);
    } else if (is_setup(path)) {
      read_setup(path);
    } else {
      read_recording(path, edits);
    }
  } catch (const InputError& problem) {
    findings_.push_back(of_input_error(path, problem));
  }
}

void PreflightFiles::read_model(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) {
    throw InputError({path}, {"there is no such file", "", "", "Check --model."});
  }
  paths_.push_back(path);
  try {
    keep_model(path, true);
  } catch (const InputError& problem) {
    findings_.push_back(of_input_error(path, problem));
  }
}

void PreflightFiles::keep_model(const std::string& path, bool chosen) {
  MusculoskeletalModel model = read_osim(path);
  for (const ModelFinding& found : check_model(model)) {
    if (found.severity == ModelFinding::Severity::kNote) continue;
    findings_.push_back(of_model_finding(path, found));
  }
  if (model_ && !(chosen && !model_is_chosen_)) return;
  model_ = std::move(model);
  model_path_ = path;
  model_is_chosen_ = chosen;
}

void PreflightFiles::read_recording(const std::string& path, const RecordingEdits& edits) {
  const Format format = format_of(path);
  if (format == Format::kC3d) {
    C3dFile& file = c3d_files_.emplace_back(read_c3d(path));
    edit_recording(file, edits);
    recordings_.push_back(preflight_recording(file));
    return;
  }
  if (format == Format::kTrc) {
    const TrcDescription description = read_trc_description(path);
    MarkerFile& file = marker_files_.emplace_back(read_trc(path));
    edit_markers(file.markers, description.metres_per_unit, edits);
    recordings_.push_back(
        preflight_recording(file, description.metres_per_unit, description.labels));
    return;
  }
  TimeTableFile table = format == Format::kCsv ? read_csv(path) : read_storage(path);
  if (format == Format::kCsv && holds_markers(table.table)) {
    recordings_.push_back(preflight_recording(marker_files_.emplace_back(markers_from_table(table)),
                                              metres_per_unit(table.table)));
    return;
  }
  recordings_.push_back(preflight_recording(tables_.emplace_back(std::move(table))));
}

void PreflightFiles::read_setup(const std::string& path) {
  std::vector<Finding> found = check_setup(path);
  std::move(found.begin(), found.end(), std::back_inserter(findings_));
}

PreflightInputs PreflightFiles::inputs() const {
  PreflightInputs inputs;
  inputs.recordings = recordings_;
  if (model_) inputs.model = &*model_;
  inputs.model_path = model_path_;
  return inputs;
}

std::string PreflightFiles::describe(const std::string& path) const {
  const auto found = std::find_if(recordings_.begin(), recordings_.end(),
                                  [&](const auto& r) { return r.path == path; });
  if (found == recordings_.end())
    return is_model(path) ? "a model" : is_setup(path) ? "a setup" : "";
  if (found->table) {
    return fmt::format("{} columns, {} rows", found->table->labels.size(),
                       found->table->time.size());
  }
  std::string line =
      fmt::format("{} markers, {} frames at {} Hz", found->markers->marker_count(),
                  found->markers->frame_count(), text::format_number(found->markers->rate));
  if (found->c3d) {
    const double platforms =
        find_number(found->c3d->groups, "FORCE_PLATFORM", "USED").value_or(0.0);
    line += fmt::format(", {} analog channels at {} Hz, {:.0f} force platforms",
                        found->c3d->analog.channel_count(),
                        text::format_number(found->c3d->analog.rate), platforms);
  }
  return line;
}

}  // namespace sinew
