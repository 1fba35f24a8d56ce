#include "data/c3d_frame_decoder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "data/c3d_bytes.h"
#include "data/numbers.h"
#include "data/text.h"

namespace sinew::c3d {
namespace {

void decode_reals(C3dProcessor processor, const unsigned char* bytes, std::vector<float>& out) {
  if (processor == C3dProcessor::kIntel && std::endian::native == std::endian::little) {
    std::memcpy(out.data(), bytes, 4 * out.size());
    return;
  }
  for (float& value : out) {
    value = real_at(processor, bytes);
    bytes += 4;
  }
}

void decode_integers(C3dProcessor processor, const unsigned char* bytes, std::size_t signed_count,
                     std::vector<float>& out) {
  for (std::size_t i = 0; i < out.size(); ++i, bytes += 2) {
    const std::uint16_t word = word_at(processor, bytes);
    out[i] = i < signed_count ? static_cast<float>(static_cast<std::int16_t>(word))
                              : static_cast<float>(word);
  }
}

bool has_unsigned_format(const C3dGroups& groups, const C3dLayout& layout,
                         const std::vector<double>& offsets) {
  const std::vector<std::string> format = find_texts(groups, "ANALOG", "FORMAT");
  if (!format.empty() && !format.front().empty()) {
    return text::lower(format.front()).starts_with("unsign");
  }
  // Without FORMAT, converters of 16 bits that count from 0 give themselves away by an offset of
  // half their range, which is negative as a signed word.
  const double lowest = offsets.empty() ? 0.0 : *std::min_element(offsets.begin(), offsets.end());
  const bool has_16_bits =
      layout.reals || find_number(groups, "ANALOG", "BITS").value_or(0.0) == 16.0;
  return has_16_bits && lowest < -32000.0;
}

}  // namespace

ChannelScales find_scales(const C3dGroups& groups, const C3dLayout& layout, const std::string& path,
                          std::vector<Warning>& warnings) {
  const auto count = static_cast<std::size_t>(layout.analog_channels);
  const char* name = find_parameter(groups, "ANALOG", "OFFSET") ? "OFFSET" : "OFFSETS";
  ChannelScales result;
  result.offset = find_numbers(groups, "ANALOG", name);
  result.is_unsigned = has_unsigned_format(groups, layout, result.offset);
  if (result.is_unsigned) result.offset = find_numbers(groups, "ANALOG", name, true);
  result.scale = find_numbers(groups, "ANALOG", "SCALE");
  if (result.scale.size() < count) {
    warnings.push_back({{path, 0},
                        fmt::format("ANALOG:SCALE has {} of {} values; the others are "
                                    "taken as 1",
                                    result.scale.size(), count)});
  }
  result.offset.resize(count, 0.0);
  result.scale.resize(count, 1.0);
  const double general = find_number(groups, "ANALOG", "GEN_SCALE").value_or(1.0);
  int unusable = 0;
  for (std::size_t i = 0; i < count; ++i) {
    result.scale[i] *= general;
    if (std::isfinite(result.scale[i]) && std::isfinite(result.offset[i])) continue;
    ++unusable;
    result.scale[i] = 1.0;
    result.offset[i] = 0.0;
  }
  if (unusable > 0) {
    warnings.push_back({{path, 0},
                        fmt::format("the scales or offsets of {} analog channels are no "
                                    "numbers; their samples are given as stored",
                                    unusable)});
  }
  return result;
}

struct FrameDecoder::Point {
  double x, y, z;  // in the file's unit
  float fourth;    // residual and cameras in one

  // Some systems write -1e9 for what they do not know; 10 km in the smallest unit is no position.
  static constexpr double kFar = 1e7;
  // False for NaN, too.
  bool is_number() const { return std::abs(x) < kFar && std::abs(y) < kFar && std::abs(z) < kFar; }
  bool is_zero() const { return x == 0.0 && y == 0.0 && z == 0.0; }
  // The sign of a 16-bit word, which systems write as a real with or without sign.
  bool is_flagged() const { return fourth < 0.0f || fourth >= 32768.0f; }
  bool is_measured() const { return !is_flagged() && is_number() && !is_zero(); }
};

FrameDecoder::FrameDecoder(const C3dFile& file, PointNames names, ChannelScales scales)
    : layout_(file.layout),
      processor_(file.header.processor),
      names_(std::move(names)),
      scales_(std::move(scales)),
      metres_(file.metres_per_unit),
      numbers_(static_cast<std::size_t>(layout_.frame_bytes) / (layout_.reals ? 4 : 2)) {}

void FrameDecoder::load(const unsigned char* bytes) {
  if (layout_.reals) return decode_reals(processor_, bytes, numbers_);
  const std::size_t signed_count =
      scales_.is_unsigned ? 4 * static_cast<std::size_t>(layout_.points) : numbers_.size();
  decode_integers(processor_, bytes, signed_count, numbers_);
}

FrameDecoder::Point FrameDecoder::point(int index) const {
  const float* at = numbers_.data() + 4 * static_cast<std::size_t>(index);
  const double scale = layout_.reals ? 1.0 : layout_.scale;
  return {at[0] * scale, at[1] * scale, at[2] * scale, at[3]};
}

void FrameDecoder::decode_marker(Eigen::Index row, Eigen::Index marker, C3dFrames& frames) {
  const Point p = point(names_.marker_points[static_cast<std::size_t>(marker)]);
  double* position = &frames.p_WM(row, 3 * marker);
  float& residual = frames.quality.residual(row, marker);
  std::uint8_t& cameras = frames.quality.cameras(row, marker);
  residual = std::numeric_limits<float>::quiet_NaN();
  cameras = 0;
  const bool flagged = p.is_flagged();
  const bool present = p.is_number() && !p.is_zero();
  if (flagged && p.fourth >= 32768.0f && !(keep_flagged_ && present)) ++counts_.by_65535;
  if (!flagged && !p.is_number()) ++counts_.not_a_number;
  if (!flagged && p.is_zero()) ++counts_.zeros;
  if (!present || (flagged && !keep_flagged_)) {
    position[0] = position[1] = position[2] = kNaN;
    return;
  }
  position[0] = p.x * metres_;
  position[1] = p.y * metres_;
  position[2] = p.z * metres_;
  if (flagged) {
    ++counts_.kept;
  } else if (!std::isnan(p.fourth)) {
    // The word's lower byte is the residual in units of the scale, the upper one the cameras.
    const int word = static_cast<int>(p.fourth);
    residual = static_cast<float>((word & 0xff) * layout_.scale * metres_);
    cameras = static_cast<std::uint8_t>(word >> 8);
  }
}

void FrameDecoder::decode(const unsigned char* bytes, Eigen::Index row, C3dFrames& frames) {
  load(bytes);
  const auto markers = static_cast<Eigen::Index>(names_.marker_points.size());
  for (Eigen::Index marker = 0; marker < markers; ++marker) decode_marker(row, marker, frames);
  for (std::size_t i = 0; i < names_.computed_points.size(); ++i) {
    const Point p = point(names_.computed_points[i]);
    const bool missing = p.is_flagged() || !p.is_number();
    double* values = &frames.computed(row, 3 * static_cast<Eigen::Index>(i));
    values[0] = missing ? kNaN : p.x;
    values[1] = missing ? kNaN : p.y;
    values[2] = missing ? kNaN : p.z;
  }
  const float* sample = numbers_.data() + 4 * static_cast<std::size_t>(layout_.points);
  const auto channels = static_cast<std::size_t>(layout_.analog_channels);
  for (int i = 0; i < layout_.analog_ratio; ++i, sample += channels) {
    double* values = frames.analog.row(row * layout_.analog_ratio + i).data();
    for (std::size_t channel = 0; channel < channels; ++channel) {
      values[channel] = (sample[channel] - scales_.offset[channel]) * scales_.scale[channel];
    }
  }
}

bool FrameDecoder::peek(const unsigned char* bytes, std::vector<double>& coordinates) {
  load(bytes);
  bool measured = false;
  coordinates.clear();
  for (const int index : names_.marker_points) {
    const Point p = point(index);
    measured = measured || p.is_measured();
    if (!p.is_number() || p.is_zero()) continue;
    coordinates.insert(coordinates.end(), {p.x, p.y, p.z});
  }
  return measured;
}

}  // namespace sinew::c3d
