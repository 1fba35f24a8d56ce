#include "data/c3d_header.h"

#include <fmt/format.h>

#include <algorithm>

#include "data/c3d_bytes.h"
#include "data/text.h"

namespace sinew::c3d {
namespace {

constexpr unsigned char kKey = 0x50;  // second byte of header and, mostly, of the parameters
constexpr int kEventKey = 12345;      // says that events follow, with labels of four characters
constexpr std::size_t kMaxEvents = 18;
// Bytes from 0 of what the manual counts as words from 1.
constexpr std::size_t kEventKeyAt = 298, kEventCountAt = 300, kEventTimesAt = 304,
                      kEventFlagsAt = 376, kEventLabelsAt = 396, kEventLabelSize = 4;

const unsigned char* bytes_of(const std::string& text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

bool is_processor(unsigned char byte) { return byte >= 84 && byte <= 86; }

// Parameters begin with two bytes that are anything, their number of blocks and the processor; then
// comes a record, whose name has a length and printable characters.
bool starts_parameters(const std::string& first, std::size_t block) {
  const std::size_t at = (block - 1) * kBlock;
  if (block < 2 || at + 8 > first.size()) return false;
  const unsigned char* bytes = bytes_of(first) + at;
  if (!is_processor(bytes[3])) return false;
  const auto length = static_cast<std::size_t>(std::abs(static_cast<signed char>(bytes[4])));
  if (length == 0) return true;  // a list without records
  if (at + 6 + length > first.size()) return false;
  return std::all_of(bytes + 6, bytes + 6 + length, [](unsigned char c) { return c >= 0x20; });
}

[[noreturn]] void fail_no_c3d(const std::string& path, const std::string& first) {
  const unsigned char* bytes = bytes_of(first);
  throw InputError({path, 0}, {"is no C3D file", "0x50 as second byte, and a parameter section",
                               fmt::format("the bytes {:02x} {:02x}", bytes[0], bytes[1]),
                               "Is it the right file?"});
}

std::vector<C3dEvent> parse_events(const unsigned char* bytes, C3dProcessor processor) {
  std::vector<C3dEvent> events;
  if (word_at(processor, bytes + kEventKeyAt) != kEventKey) return events;
  const std::size_t count =
      std::min<std::size_t>(word_at(processor, bytes + kEventCountAt), kMaxEvents);
  for (std::size_t i = 0; i < count; ++i) {
    const auto* label = reinterpret_cast<const char*>(bytes + kEventLabelsAt + kEventLabelSize * i);
    std::string_view text(label, kEventLabelSize);
    text = text.substr(0, std::min(text.size(), text.find('\0')));
    const double time = real_at(processor, bytes + kEventTimesAt + 4 * i);
    if (!std::isfinite(time)) continue;
    events.push_back({.time = time,
                      .label = std::string(text::trim(text)),
                      .context = "",
                      .subject = "",
                      .description = "",
                      .in_header = true});
  }
  return events;
}

void put_word(std::string& out, std::size_t at, std::size_t value) {
  out[at] = static_cast<char>(value & 0xff);
  out[at + 1] = static_cast<char>(value >> 8 & 0xff);
}

void put_real(std::string& out, std::size_t at, double value) {
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  put_word(out, at, bits & 0xffff);
  put_word(out, at + 2, bits >> 16);
}

void put_events(std::string& out, const std::vector<C3dEvent>& events) {
  const std::size_t count = std::min(events.size(), kMaxEvents);
  put_word(out, kEventKeyAt, kEventKey);
  put_word(out, kEventCountAt, count);
  for (std::size_t i = 0; i < count; ++i) {
    put_real(out, kEventTimesAt + 4 * i, events[i].time);
    out[kEventFlagsAt + i] = 1;  // shown
    std::string label = events[i].label;
    label.resize(kEventLabelSize, ' ');
    out.replace(kEventLabelsAt + kEventLabelSize * i, kEventLabelSize, label);
  }
}

}  // namespace

ParameterStart find_parameters(const std::string& path, const std::string& first,
                               std::vector<Warning>& warnings) {
  if (first.empty()) {
    throw InputError({path, 0}, {"is empty", "a C3D file", "", "Was it written completely?"});
  }
  if (first.size() < 2 * kBlock) {
    throw InputError({path, 0},
                     {"is too short for a C3D file", "at least 1024 bytes: a header and parameters",
                      fmt::format("{}", first.size()), "Was it written completely?"});
  }
  const std::size_t named = bytes_of(first)[0];
  const bool has_key = bytes_of(first)[1] == kKey;
  std::size_t block = 0;
  if (starts_parameters(first, named)) block = named;
  // Without the key a chance pattern deep in the file is no evidence.
  const std::size_t last = has_key ? first.size() / kBlock : 2;
  for (std::size_t i = 2; block == 0 && i <= last; ++i) {
    if (starts_parameters(first, i)) block = i;
  }
  if (block == 0 || (!has_key && block != named)) fail_no_c3d(path, first);
  if (!has_key) {
    warnings.push_back({{path, 0},
                        fmt::format("the header's second byte is {:#04x} instead of "
                                    "0x50; the file was read as C3D all the same",
                                    bytes_of(first)[1])});
  }
  if (block != named) {
    warnings.push_back({{path, 0},
                        fmt::format("the header points to parameters in block {}; they "
                                    "were found in block {}",
                                    named, block)});
  }
  return {static_cast<int>(block), C3dProcessor{bytes_of(first)[(block - 1) * kBlock + 3]}};
}

C3dHeader parse_header(const std::string& first, C3dProcessor processor) {
  const unsigned char* bytes = bytes_of(first);
  const auto word = [&](std::size_t at) {
    return static_cast<int>(word_at(processor, bytes + at));
  };
  C3dHeader header;
  header.processor = processor;
  header.parameter_block = bytes[0];
  header.points = word(2);
  header.analog_per_frame = word(4);
  header.first_frame = word(6);
  header.last_frame = word(8);
  header.max_gap = word(10);
  header.scale = real_at(processor, bytes + 12);
  header.data_block = word(16);
  header.analog_ratio = word(18);
  header.rate = real_at(processor, bytes + 20);
  header.events = parse_events(bytes, processor);
  return header;
}

std::string format_header(const C3dHeader& header) {
  std::string out(kBlock, '\0');
  out[0] = static_cast<char>(header.parameter_block);
  out[1] = kKey;
  const auto capped = [](int value) {
    return static_cast<std::size_t>(std::clamp(value, 0, 0xffff));
  };
  put_word(out, 2, capped(header.points));
  put_word(out, 4, capped(header.analog_per_frame));
  put_word(out, 6, capped(header.first_frame));
  put_word(out, 8, capped(header.last_frame));
  put_word(out, 10, capped(header.max_gap));
  put_real(out, 12, header.scale);
  put_word(out, 16, capped(header.data_block));
  put_word(out, 18, capped(header.analog_ratio));
  put_real(out, 20, header.rate);
  put_events(out, header.events);
  return out;
}

}  // namespace sinew::c3d
