#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "data/c3d_parameters.h"

namespace sinew {

/// The bytes of a C3D file, put together record by record as the manual of the format has them and
/// without write_c3d, which cannot write most of what is found in the wild.
class RawC3d {
 public:
  explicit RawC3d(C3dProcessor processor) : processor_(processor) {}

  // Words of the header, by their names there.
  int points = 0, samples_per_frame = 0, first_frame = 1, last_frame = 1, ratio = 0;
  float scale = -1.0f, rate = 100.0f;

  RawC3d& group(int id, const std::string& name) {
    start(name, -id);
    finish("", "");
    return *this;
  }
  RawC3d& integers(int id, const std::string& name, const std::vector<int>& values,
                   std::vector<int> dimensions = {}) {
    std::string data;
    for (const int value : values) put_word(data, value);
    return parameter(id, name, 2, values.size(), std::move(dimensions), data);
  }
  RawC3d& reals(int id, const std::string& name, const std::vector<float>& values,
                std::vector<int> dimensions = {}) {
    std::string data;
    for (const float value : values) put_real(data, value);
    return parameter(id, name, 4, values.size(), std::move(dimensions), data);
  }
  RawC3d& texts(int id, const std::string& name, const std::vector<std::string>& values,
                std::size_t width) {
    std::string data;
    for (std::string value : values) {
      value.resize(width, ' ');
      data += value;
    }
    const std::vector<int> dimensions = {static_cast<int>(width), static_cast<int>(values.size())};
    return parameter(id, name, -1, values.size(), dimensions, data);
  }

  /// Numbers of the data section, as `scale` says: integers or reals.
  RawC3d& data(const std::vector<double>& values) {
    for (const double value : values) {
      if (scale > 0.0f) {
        put_word(data_, static_cast<int>(value));
      } else {
        put_real(data_, static_cast<float>(value));
      }
    }
    return *this;
  }

  std::string bytes() const {
    std::string parameters = {1, 0x50, 0, static_cast<char>(processor_)};
    parameters += records_;
    pad(parameters, 2);
    parameters[2] = static_cast<char>(parameters.size() / 512);
    std::string all = {2, 0x50};
    for (const int word : {points, samples_per_frame, first_frame, last_frame, 0}) {
      put_word(all, word);
    }
    put_real(all, scale);
    put_word(all, static_cast<int>(2 + parameters.size() / 512));
    put_word(all, ratio);
    put_real(all, rate);
    pad(all, 0);
    all += parameters + data_;
    pad(all, 0);
    return all;
  }

 private:
  // To whole blocks, with `zeros` of them at least.
  static void pad(std::string& out, std::size_t zeros) {
    out.resize((out.size() + zeros + 511) / 512 * 512, '\0');
  }
  void put_word(std::string& out, int value) const {
    const bool big = processor_ == C3dProcessor::kMips;
    const char low = static_cast<char>(value & 0xff), high = static_cast<char>(value >> 8 & 0xff);
    out += big ? high : low;
    out += big ? low : high;
  }
  void put_real(std::string& out, float value) const {
    const bool dec = processor_ == C3dProcessor::kDec;
    // DEC's exponents count from a quarter, and its words stand the other way round.
    const auto bits = std::bit_cast<std::uint32_t>(dec ? 4.0f * value : value);
    const int high = static_cast<int>(bits >> 16), low = static_cast<int>(bits & 0xffff);
    const bool high_first = processor_ != C3dProcessor::kIntel;
    put_word(out, high_first ? high : low);
    put_word(out, high_first ? low : high);
  }

  void start(const std::string& name, int id) {
    records_ += static_cast<char>(name.size());
    records_ += static_cast<char>(id);
    records_ += name;
  }
  void finish(const std::string& body, const std::string& description) {
    put_word(records_, static_cast<int>(2 + body.size() + 1 + description.size()));
    records_ += body;
    records_ += static_cast<char>(description.size());
    records_ += description;
  }
  // A scalar where there is one value and no dimension.
  RawC3d& parameter(int id, const std::string& name, int type, std::size_t count,
                    std::vector<int> dimensions, const std::string& data) {
    if (dimensions.empty() && count != 1) dimensions = {static_cast<int>(count)};
    std::string body = {static_cast<char>(type), static_cast<char>(dimensions.size())};
    for (const int size : dimensions) body += static_cast<char>(size);
    start(name, id);
    finish(body + data, "of " + name);
    return *this;
  }

  C3dProcessor processor_;
  std::string records_, data_;
};

}  // namespace sinew
