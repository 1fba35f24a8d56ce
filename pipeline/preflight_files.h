#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "data/c3d_file.h"
#include "data/marker_trajectories.h"
#include "data/recording_edits.h"
#include "data/time_table.h"
#include "model/musculoskeletal_model.h"
#include "pipeline/preflight.h"

namespace sinew {

/// Files of any kind that Sinew reads, read for run_preflight, which they must outlive. A file that
/// cannot be read is a finding.
class PreflightFiles {
 public:
  /// Reads C3D, TRC, MOT, STO, CSV, .osim or a setup, tasks or loads in XML, by its ending. Throws
  /// InputError if there is no such file and for other endings. C3D and TRC files are put right as
  /// `edits` say before they are looked at; throws as edit_recording().
  void read(const std::string& path, const RecordingEdits& edits = {});
  /// The model that markers are held against, rather than the first .osim among the files.
  void read_model(const std::string& path);

  /// Everything that was read; valid as long as this object and until the next file.
  PreflightInputs inputs() const;
  /// One line a recording: `44 markers, 1249 frames at 250 Hz, 2 force platforms`.
  std::string describe(const std::string& path) const;

  const std::vector<std::string>& paths() const { return paths_; }
  /// Of files that cannot be read, models and setups.
  const std::vector<Finding>& findings() const { return findings_; }

 private:
  void read_recording(const std::string& path, const RecordingEdits& edits);
  void read_setup(const std::string& path);
  void keep_model(const std::string& path, bool chosen);

  std::vector<std::string> paths_;
  // Addresses must stay: recordings point to them.
  std::deque<C3dFile> c3d_files_;
  std::deque<MarkerFile> marker_files_;
  std::deque<TimeTableFile> tables_;
  std::vector<PreflightRecording> recordings_;
  std::optional<MusculoskeletalModel> model_;
  std::string model_path_;
  bool model_is_chosen_ = false;
  std::vector<Finding> findings_;
};

}  // namespace sinew
