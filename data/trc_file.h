#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "data/marker_trajectories.h"
#include "data/output_file.h"

namespace sinew {

/// Reads a TRC file (marker trajectories, cells separated by tabs, or by blanks where no cell is
/// blank) and converts mm, cm or m to metres with one rounding: 617.2 mm is the double nearest to
/// 0.6172. The rate is the header's DataRate; frame numbers are kept as they are. A marker is not
/// measured, NaN, where a coordinate is blank or NaN in any case, and at exactly 0, 0, 0.
/// Warns where: NumFrames, NumMarkers or DataRate disagree with the file, markers have no name
/// (unnamed_1, ...) or an earlier one's (NAME_2, ...), names have no coordinates, samples are
/// at 0, 0, 0 or incomplete, rows end early at a whole marker, the last one has no end.
/// Throws InputError for what cannot be used: no, empty, binary or cut file, a header without
/// DataRate, NumFrames, NumMarkers or known Units, names that fit no coordinates, no frames, a torn
/// row, a value that is no number, time that does not increase.
/// O(bytes) in time and memory, whatever the header promises.
MarkerFile read_trc(const std::filesystem::path& path);

/// Writes markers as TRC in millimetres, missing samples blank; atomic like write_storage. Reading
/// the file again gives the same bits. Throws InputError if the file cannot be written or if sizes
/// or names make no table.
void write_trc(const std::filesystem::path& path, const MarkerTrajectories& markers);

/// How exactly positions are printed.
enum class TrcPrecision {
  kDouble,  // reading gives the same bits
  kSingle,  // reading, rounded to 32 bits in mm, gives the same: all that a C3D file holds
};

/// Writes a TRC file block by block: memory does not depend on the number of frames. What `finish`
/// has not completed is removed.
class TrcWriter {
 public:
  struct Header {
    std::vector<std::string> names;
    double rate = 0.0;  // [Hz]
    std::int64_t frames = 0, first_frame = 1;
  };

  /// Throws InputError as write_trc does.
  TrcWriter(const std::filesystem::path& path, const Header& header,
            TrcPrecision precision = TrcPrecision::kDouble);

  /// One frame: x, y, z of each marker [m]; NaN = not measured.
  void append(std::int64_t frame_number, double time, const double* p_WM);
  /// Throws InputError if the header promised another number of frames.
  void finish();

 private:
  std::string path_;
  const std::size_t coordinates_;
  const std::int64_t frames_;
  const TrcPrecision precision_;
  std::int64_t written_ = 0;
  OutputFile file_;
  std::string buffer_;
};

}  // namespace sinew
