#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "data/c3d_file.h"

namespace sinew {

/// Some frames of a C3D file; columns as in C3dFile.
struct C3dFrames {
  std::int64_t first = 0;  // how many frames of the file come before
  RowMatrix p_WM;          // frames × 3·markers [m]; NaN = not measured
  C3dQuality quality;      // frames × markers
  RowMatrix computed;      // frames × 3·trajectories
  RowMatrix analog;        // samples × channels
};

/// Reads a C3D file piece by piece: memory does not depend on the number of frames.
///
/// Understood in all byte orders, as reals or integers: group and parameter lists in any order,
/// without terminator, with wrong block counts or pointers; more than 255 labels (LABELS2, ...);
/// more than 65535 frames (TRIAL:ACTUAL_START_FIELD, POINT:LONG_FRAMES); signed and unsigned
/// samples. A point is not measured where its fourth number is negative as a 16-bit word (-1, or
/// 65535.0 as some systems write), where a coordinate is NaN and at exactly 0, 0, 0. If that leaves
/// no point in the whole file though coordinates are there, those are taken. Warns where: header,
/// parameters and size disagree (see c3d_layout.h), the file ends early, the unit of lengths is
/// missing, unknown or judged from the extents, labels are missing or repeated, points are flagged
/// in an unusual way, scales of channels are missing. Throws InputError for: no, empty or other
/// file, one that ends before its first frame, no rate. O(bytes) in time.
class C3dReader {
 public:
  explicit C3dReader(const std::filesystem::path& path);
  ~C3dReader();
  C3dReader(C3dReader&&) noexcept;
  C3dReader& operator=(C3dReader&&) noexcept;

  /// Everything but the frames: tables of time, positions and samples are empty. Warnings about
  /// frames are added when the last one is read.
  const C3dFile& description() const;
  std::int64_t frames_left() const;
  /// Reads the next `max_frames` frames, or as many as are left, in place of those in `frames`.
  /// Returns how many; 0 at the end. Allocates only if `frames` has to grow.
  int read(int max_frames, C3dFrames& frames);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sinew
