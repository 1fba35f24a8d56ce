#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data/c3d_file.h"
#include "data/marker_trajectories.h"
#include "data/time_table.h"

namespace sinew {

/// Two markers that exchange their names, in the whole record or a part of it, both ends included.
struct NameSwap {
  std::string a, b;
  std::optional<double> from, to;  // [s]
};
/// A marker that is left out, in the whole record or a part of it.
struct MarkerDrop {
  std::string name;
  std::optional<double> from, to;  // [s]
};
struct MarkerRename {
  std::string from, to;
};
/// A time in which a platform carries nothing; all platforms where `plate` is 0.
struct UnloadedTime {
  int plate = 0;
  double from = 0.0, to = 0.0;  // [s]
};

/// Samples of an analog channel, or of a table's column, that are left out.
struct SampleDrop {
  std::string channel;
  double from = 0.0, to = 0.0;  // [s]
};

/// What is wrong in a recording and how it is put right, in this order: the unit of lengths, names
/// exchanged, markers left out, sides, names, spikes; then samples left out, the platforms'
/// baseline and the clock of all channels. Names are those that the recording has when its turn
/// comes.
struct RecordingEdits {
  std::string unit;  // of the file's lengths, whatever it says: mm, cm, m, in, ft
  std::vector<NameSwap> swaps;
  std::vector<MarkerDrop> drops;
  bool swap_sides = false;  // every left marker's name for that of its right partner
  std::vector<MarkerRename> renames;
  std::vector<MarkerDrop> spikes;  // by the names that there are then
  std::vector<SampleDrop> samples;
  std::vector<UnloadedTime> unloaded;
  double shift_forces = 0.0;  // what channels and tables of forces are moved to later times [s]

  bool any() const { return edits_markers() || edits_forces(); }
  bool edits_markers() const;
  bool edits_forces() const { return !samples.empty() || !unloaded.empty() || shift_forces != 0.0; }
};

// `A,B` or `A,B@FROM-TO`; `NAME` or `NAME@FROM-TO`; `OLD=NEW`; `FROM-TO` or `PLATE@FROM-TO`.
// `CHANNEL@FROM-TO`. Nothing for other texts. A name may hold an `@` that no times follow.
std::optional<NameSwap> parse_swap(const std::string& text);
std::optional<MarkerDrop> parse_drop(const std::string& text);
std::optional<MarkerRename> parse_rename(const std::string& text);
std::optional<UnloadedTime> parse_unloaded(const std::string& text);
std::optional<SampleDrop> parse_sample_drop(const std::string& text);

// The same texts.
std::string to_text(const MarkerDrop& drop);
std::string to_text(const SampleDrop& drop);

/// Edits markers whose file has lengths of `metres_per_unit`. Throws std::invalid_argument, naming
/// the option, for a marker that is not there, a time without frames, a name that is taken, and if
/// no marker is left.
void edit_markers(MarkerTrajectories& markers, double metres_per_unit, const RecordingEdits& edits);

/// The same of a C3D file, and its channels. Parameters of places follow the unit unless platforms
/// have sensible corners only in the old one. A channel's baseline is its mean over the unloaded
/// time; from one such time to the next it goes on a straight line. Where samples are left out, a
/// channel goes straight from the one before to the one behind. Samples that a shift brings in
/// from outside the record are the first or last one's.
/// Throws std::invalid_argument also for a platform that is not there or cannot be used.
void edit_recording(C3dFile& file, const RecordingEdits& edits);

/// Leaves samples of a table's columns out. Throws as edit_recording().
void drop_samples(TimeTable& table, const std::vector<SampleDrop>& samples);

}  // namespace sinew
