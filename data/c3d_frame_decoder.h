#pragma once

#include <string>
#include <vector>

#include "data/c3d_file.h"
#include "data/c3d_labels.h"
#include "data/c3d_reader.h"

namespace sinew::c3d {

/// Turns stored samples to physical values: (sample - offset) × scale.
struct ChannelScales {
  std::vector<double> offset, scale;  // one a channel; GEN_SCALE is in scale
  bool is_unsigned = false;           // stored integers are
};

/// ANALOG:OFFSET, SCALE, GEN_SCALE, FORMAT and BITS. Warns where scales are missing.
ChannelScales find_scales(const C3dGroups& groups, const C3dLayout& layout, const std::string& path,
                          std::vector<Warning>& warnings);

/// What was odd about points, in numbers of them.
struct PointCounts {
  std::int64_t zeros = 0;  // at 0, 0, 0 without being flagged
  std::int64_t not_a_number = 0;
  std::int64_t by_65535 = 0;  // flagged by 65535.0
  std::int64_t kept = 0;      // flagged, but taken all the same
};

/// Decodes frames, each from its bytes.
class FrameDecoder {
 public:
  FrameDecoder(const C3dFile& file, PointNames names, ChannelScales scales);

  /// Fills one row of markers and computed trajectories and the frame's rows of samples.
  void decode(const unsigned char* bytes, Eigen::Index row, C3dFrames& frames);
  /// The coordinates of markers in the file's unit, frame's rows × 3·markers, flagged ones too.
  /// True if one of them is measured.
  bool peek(const unsigned char* bytes, std::vector<double>& coordinates);
  /// From now on flagged points are taken where they have coordinates.
  void keep_flagged() { keep_flagged_ = true; }
  void set_metres_per_unit(double metres) { metres_ = metres; }
  const PointCounts& counts() const { return counts_; }

 private:
  struct Point;
  void load(const unsigned char* bytes);
  Point point(int index) const;
  void decode_marker(Eigen::Index row, Eigen::Index marker, C3dFrames& frames);

  const C3dLayout layout_;
  const C3dProcessor processor_;
  const PointNames names_;
  const ChannelScales scales_;
  double metres_ = 1e-3;
  bool keep_flagged_ = false;
  PointCounts counts_;
  std::vector<float> numbers_;  // of one frame
};

}  // namespace sinew::c3d
