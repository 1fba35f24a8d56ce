#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "data/c3d_parameters.h"

/// Numbers as C3D files store them. Nothing here checks bounds.
namespace sinew::c3d {

inline constexpr std::size_t kBlock = 512;  // bytes; what every pointer of the format counts in

inline std::uint16_t word_at(C3dProcessor processor, const unsigned char* at) {
  const bool big = processor == C3dProcessor::kMips;
  return static_cast<std::uint16_t>(big ? at[0] << 8 | at[1] : at[1] << 8 | at[0]);
}

inline std::int16_t integer_at(C3dProcessor processor, const unsigned char* at) {
  return static_cast<std::int16_t>(word_at(processor, at));
}

/// A number of DEC's F_floating format, given sign, exponent and fraction in IEEE's places. The
/// exponent's bias is 128 and the hidden bit stands behind the point: a quarter of what IEEE reads.
inline float dec_to_ieee(std::uint32_t bits) {
  const std::uint32_t exponent = bits >> 23 & 0xff;
  if (exponent > 2) return std::bit_cast<float>(bits - (2u << 23));
  if (exponent == 0) {  // zero, or what DEC reserved for faults
    return bits >> 31 ? std::numeric_limits<float>::quiet_NaN() : 0.0f;
  }
  const float size = std::ldexp(static_cast<float>((bits & 0x7fffff) | 0x800000),
                                static_cast<int>(exponent) - 128 - 24);
  return bits >> 31 ? -size : size;
}

inline float real_at(C3dProcessor processor, const unsigned char* at) {
  const std::uint32_t first = word_at(processor, at), second = word_at(processor, at + 2);
  switch (processor) {
    case C3dProcessor::kIntel:
      return std::bit_cast<float>(second << 16 | first);
    case C3dProcessor::kMips:
      return std::bit_cast<float>(first << 16 | second);
    case C3dProcessor::kDec:
      return dec_to_ieee(first << 16 | second);
  }
  return std::numeric_limits<float>::quiet_NaN();
}

}  // namespace sinew::c3d
