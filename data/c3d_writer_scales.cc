#include "data/c3d_writer_scales.h"

#include <algorithm>
#include <cmath>

#include "data/c3d_frame_decoder.h"

namespace sinew::c3d {
namespace {

constexpr double kLargest = 32767.0;    // of 16 bits
constexpr double kFullScale = 32000.0;  // leaves room for rounding
constexpr double kMaxResidual = 255.0;  // of a byte

// Without NaN.
double largest(const RowMatrix& values) {
  double result = 0.0;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const double value = std::abs(values.data()[i]);
    if (value > result && std::isfinite(value)) result = value;
  }
  return result;
}

float choose_point_scale(const C3dFile& file, bool integers) {
  const double old = file.layout.scale;
  if (integers) {
    const double most =
        std::max(largest(file.markers.p_WM) / file.metres_per_unit, largest(file.computed.values));
    if (!file.layout.reals && most <= kLargest * old) return static_cast<float>(old);
    return most > 0.0 ? static_cast<float>(most / kFullScale) : 1.0f;
  }
  double most = 0.0;
  for (Eigen::Index i = 0; i < file.quality.residual.size(); ++i) {
    const double residual = file.quality.residual.data()[i] / file.metres_per_unit;
    if (residual > most && std::isfinite(residual)) most = residual;
  }
  // Half a step more: residuals are rounded.
  if (most <= (kMaxResidual + 0.5) * old) return static_cast<float>(old);
  return static_cast<float>(most / kMaxResidual);
}

// Whether all values of a channel fit 16 bits.
bool fits(const RowMatrix& values, Eigen::Index channel, double scale, double offset) {
  if (!(std::abs(scale) > 0.0) || offset != std::round(offset) || std::abs(offset) > kLargest) {
    return false;
  }
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    // False for NaN as well, which no integer is.
    if (std::abs(values(i, channel) / scale + offset) > kLargest) return false;
  }
  return true;
}

}  // namespace

StoredScales choose_scales(const C3dFile& file, bool integers) {
  const auto channels = static_cast<std::size_t>(file.analog.channel_count());
  StoredScales result;
  result.point = choose_point_scale(file, integers);
  result.channel.assign(channels, 1.0f);
  result.offset.assign(channels, 0);
  if (!integers) return result;
  std::vector<Warning> ignored;  // given when the file was read
  const ChannelScales old = find_scales(file.groups, file.layout, file.path, ignored);
  const bool same_channels = !file.layout.reals && old.scale.size() == channels;
  for (std::size_t i = 0; i < channels; ++i) {
    const auto channel = static_cast<Eigen::Index>(i);
    if (same_channels && fits(file.analog.values, channel, old.scale[i], old.offset[i])) {
      result.channel[i] = static_cast<float>(old.scale[i]);
      result.offset[i] = static_cast<std::int16_t>(old.offset[i]);
      continue;
    }
    const double most = largest(file.analog.values.col(channel));
    if (most > 0.0) result.channel[i] = static_cast<float>(most / kFullScale);
  }
  return result;
}

}  // namespace sinew::c3d
