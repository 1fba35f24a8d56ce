#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "data/c3d_file.h"
#include "data/marker_trajectories.h"
#include "data/time_table.h"

namespace sinew {

enum class Format { kC3d, kTrc, kMot, kSto, kCsv };

constexpr const char* kRecordingFormats = ".c3d, .trc, .mot, .sto or .csv";

/// By the ending of the name. Throws InputError for any other.
Format format_of(const std::filesystem::path& path);

/// A file that is no C3D file, read: markers or a table.
struct Recording {
  std::string path;
  std::optional<MarkerTrajectories> markers;
  std::optional<TimeTable> table;
  double metres_per_unit = 1.0;  // of the lengths that the file names
};

/// Reads TRC, MOT, STO or CSV and prints warnings. A CSV file whose columns are NAME.x, NAME.y,
/// NAME.z holds markers. Throws InputError as the readers do, and for a table without rows.
Recording read_recording(const std::string& path, std::vector<Warning>& warnings);

/// Takes the columns of a table as markers; throws InputError where they are none.
void require_markers(Recording& recording);

/// One recording of markers, and tables as analog channels: at the least whole multiple of the
/// markers' rate that is not below the table's own, by cubic splines. Throws InputError for a
/// second recording of markers, tables of different rates and one that does not cover the markers.
C3dFile merge_to_c3d(const std::vector<Recording>& recordings, const std::string& path);

/// Frames first … end − 1 of everything in the file; events count from the new first frame, and
/// those outside are dropped.
void crop(C3dFile& file, int first, int end);

}  // namespace sinew
