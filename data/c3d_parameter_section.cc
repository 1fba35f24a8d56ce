#include "data/c3d_parameter_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "data/c3d_bytes.h"
#include "data/text.h"

namespace sinew::c3d {
namespace {

// Types as the byte before the dimensions names them; also the size of a value.
constexpr int kCharacter = -1, kByte = 1, kInteger = 2, kReal = 4;
// Of the format; more would be read from bytes that are no parameter.
constexpr int kMaxDimensions = 7;

// Walks over the records.
class Parser {
 public:
  Parser(const std::string& path, std::string_view bytes, std::size_t offset, std::size_t declared,
         C3dProcessor processor, std::vector<Warning>& warnings)
      : path_(path),
        bytes_(bytes),
        offset_(offset),
        declared_(declared),
        processor_(processor),
        warnings_(warnings) {}

  C3dGroups parse() {
    while (parse_record()) {
    }
    return assemble();
  }

 private:
  struct Record {
    int id = 0;
    std::size_t at = 0;
    C3dParameter parameter;
  };

  const unsigned char* data(std::size_t at) const {
    return reinterpret_cast<const unsigned char*>(bytes_.data()) + at;
  }
  int signed_byte(std::size_t at) const { return static_cast<signed char>(bytes_[at]); }
  bool holds(std::size_t at, std::size_t count) const {
    return at <= bytes_.size() && count <= bytes_.size() - at;
  }
  void warn(std::size_t at, const std::string& text) {
    warnings_.push_back({{path_, 0}, fmt::format("at byte {}: {}", offset_ + at, text)});
  }
  bool stop(const std::string& reason) {
    warn(at_, fmt::format("the list of parameters ends in {}; the {} bytes from there to the data "
                          "were not read",
                          reason, bytes_.size() - at_));
    return false;
  }

  // False at the end of the list.
  bool parse_record() {
    if (!holds(at_, 2) || bytes_[at_] == 0) return false;
    const bool locked = signed_byte(at_) < 0;
    const auto length = static_cast<std::size_t>(std::abs(signed_byte(at_)));
    const int id = signed_byte(at_ + 1);
    const std::size_t next_at = at_ + 2 + length;
    if (id == 0 || !holds(next_at, 2)) return stop("what is no record");
    std::string name(bytes_.substr(at_ + 2, length));
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20; };
    const auto is_beyond_ascii = [](char c) { return static_cast<unsigned char>(c) > 0x7e; };
    if (std::any_of(name.begin(), name.end(), is_control) ||
        (at_ >= declared_ && std::any_of(name.begin(), name.end(), is_beyond_ascii))) {
      return stop("what is no record");
    }
    name = text::trim(name);
    const std::size_t next = word_at(processor_, data(next_at));
    if (id < 0) {
      groups_.push_back({-id, std::move(name), description(next_at + 2), locked, {}});
    } else if (!parse_parameter(id, std::move(name), locked, next_at + 2, next)) {
      return false;
    }
    if (next < 2) return false;  // the last record points to nothing
    at_ = next_at + next;
    return true;
  }

  bool parse_parameter(int id, std::string name, bool locked, std::size_t at, std::size_t next) {
    if (!holds(at, 2)) return stop("a parameter without a type");
    const int type = signed_byte(at);
    const auto rank = static_cast<int>(static_cast<unsigned char>(bytes_[at + 1]));
    const bool known = type == kCharacter || type == kByte || type == kInteger || type == kReal;
    if (!known || rank > kMaxDimensions || !holds(at + 2, static_cast<std::size_t>(rank))) {
      if (next < 2 || !holds(at - 2, next)) return stop("what is no record");
      warn(at_, fmt::format("parameter {} has the unknown type {} with {} dimensions; it was left "
                            "out",
                            name, type, rank));
      return true;
    }
    C3dParameter parameter;
    parameter.name = std::move(name);
    parameter.locked = locked;
    std::size_t count = 1;
    for (int i = 0; i < rank; ++i) {
      parameter.dimensions.push_back(
          static_cast<unsigned char>(bytes_[at + 2 + static_cast<std::size_t>(i)]));
      count *= static_cast<std::size_t>(parameter.dimensions.back());  // at most 255^7
    }
    const std::size_t values_at = at + 2 + static_cast<std::size_t>(rank);
    const std::size_t size = static_cast<std::size_t>(std::abs(type));
    if (count > bytes_.size() || !holds(values_at, count * size)) {
      return stop(
          fmt::format("parameter {}, whose {} values reach into the data", parameter.name, count));
    }
    fill(parameter, type, values_at, count);
    parameter.description = description(values_at + count * size);
    records_.push_back({id, at_, std::move(parameter)});
    return true;
  }

  void fill(C3dParameter& parameter, int type, std::size_t at, std::size_t count) const {
    if (type == kCharacter) {
      parameter.values = std::string(bytes_.substr(at, count));
    } else if (type == kByte) {
      parameter.values = std::vector<std::uint8_t>(data(at), data(at) + count);
    } else if (type == kInteger) {
      std::vector<std::int16_t> values(count);
      for (std::size_t i = 0; i < count; ++i) values[i] = integer_at(processor_, data(at + 2 * i));
      parameter.values = std::move(values);
    } else {
      std::vector<float> values(count);
      for (std::size_t i = 0; i < count; ++i) values[i] = real_at(processor_, data(at + 4 * i));
      parameter.values = std::move(values);
    }
  }

  std::string description(std::size_t at) const {
    if (!holds(at, 1)) return "";
    const std::size_t length = static_cast<unsigned char>(bytes_[at]);
    return holds(at + 1, length) ? std::string(bytes_.substr(at + 1, length)) : "";
  }

  C3dGroups assemble() {
    C3dGroups result;
    std::vector<int> place_of_id(128, -1);  // in result
    for (C3dGroup& group : groups_) {
      int& place = place_of_id[static_cast<std::size_t>(std::min(group.id, 127))];
      const auto same = [&](const C3dGroup& other) {
        return text::equals_ignoring_case(other.name, group.name);
      };
      const auto found = std::find_if(result.begin(), result.end(), same);
      if (place >= 0 || found != result.end()) {
        warn(0, fmt::format("group {} (number {}) is declared more than once; its parameters were "
                            "put together",
                            group.name, group.id));
      }
      if (place >= 0) continue;
      place = static_cast<int>(found - result.begin());
      if (found == result.end()) result.push_back(std::move(group));
    }
    for (Record& record : records_) add(record, result, place_of_id);
    return result;
  }

  void add(Record& record, C3dGroups& result, std::vector<int>& place_of_id) {
    int& place = place_of_id[static_cast<std::size_t>(record.id)];
    if (place < 0) {
      warn(record.at, fmt::format("parameter {} belongs to group number {}, which is not declared",
                                  record.parameter.name, record.id));
      place = static_cast<int>(result.size());
      result.push_back({record.id, fmt::format("GROUP_{}", record.id), "", false, {}});
    }
    C3dGroup& group = result[static_cast<std::size_t>(place)];
    const C3dParameter* old = group.find(record.parameter.name);
    if (old == nullptr) {
      group.parameters.push_back(std::move(record.parameter));
    } else if (old->values != record.parameter.values) {
      warn(record.at, fmt::format("{}:{} is given twice with different values; the first were used",
                                  group.name, old->name));
    }
  }

  const std::string& path_;
  const std::string_view bytes_;
  const std::size_t offset_, declared_;
  const C3dProcessor processor_;
  std::vector<Warning>& warnings_;
  std::size_t at_ = 0;
  std::vector<C3dGroup> groups_;
  std::vector<Record> records_;
};

void put_word(std::string& out, std::size_t value) {
  out += static_cast<char>(value & 0xff);
  out += static_cast<char>(value >> 8 & 0xff);
}

void put_name(std::string& out, const std::string& name, bool locked, int id) {
  const std::string cut = name.empty() ? "_" : name.substr(0, 127);
  const auto length = static_cast<int>(cut.size());
  out += static_cast<char>(locked ? -length : length);
  out += static_cast<char>(id);
  out += cut;
}

// The length is a byte, but programs are about that take it for a signed one and lose their way.
constexpr std::size_t kMaxDescription = 127;

void put_description(std::string& out, const std::string& description) {
  const std::string cut = description.substr(0, kMaxDescription);
  out += static_cast<char>(cut.size());
  out += cut;
}

std::string format_values(const C3dParameter& parameter) {
  std::string out;
  if (const auto* characters = std::get_if<std::string>(&parameter.values)) {
    out = *characters;
  } else if (const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&parameter.values)) {
    out.assign(bytes->begin(), bytes->end());
  } else if (const auto* words = std::get_if<std::vector<std::int16_t>>(&parameter.values)) {
    for (const std::int16_t value : *words) put_word(out, static_cast<std::uint16_t>(value));
  } else {
    for (const float value : std::get<std::vector<float>>(parameter.values)) {
      const auto bits = std::bit_cast<std::uint32_t>(value);
      put_word(out, bits & 0xffff);
      put_word(out, bits >> 16);
    }
  }
  return out;
}

void put_parameter(const std::string& path, const C3dGroup& group, const C3dParameter& parameter,
                   std::string& out) {
  static constexpr std::array<int, 4> kTypes = {kCharacter, kByte, kInteger, kReal};
  std::string body;
  body += static_cast<char>(kTypes[parameter.values.index()]);
  body += static_cast<char>(parameter.dimensions.size());
  for (const int dimension : parameter.dimensions) body += static_cast<char>(dimension);
  body += format_values(parameter);
  put_description(body, parameter.description);
  if (body.size() + 2 > std::numeric_limits<std::uint16_t>::max()) {
    throw InputError(
        {path, 0},
        {fmt::format("parameter {}:{} does not fit the format", group.name, parameter.name),
         "at most 65533 bytes", fmt::format("{}", body.size()), "Shorten its texts or split it."});
  }
  put_name(out, parameter.name, parameter.locked, group.id);
  put_word(out, body.size() + 2);
  out += body;
}

}  // namespace

C3dGroups parse_parameters(const std::string& path, std::string_view bytes, std::size_t offset,
                           std::size_t declared, C3dProcessor processor,
                           std::vector<Warning>& warnings) {
  return Parser(path, bytes, offset, declared, processor, warnings).parse();
}

std::string format_parameters(const std::string& path, const C3dGroups& groups) {
  std::string out = {1, 0x50, 0, static_cast<char>(C3dProcessor::kIntel)};
  for (const C3dGroup& group : groups) {
    put_name(out, group.name, group.locked, -group.id);
    put_word(out, 3 + std::min(group.description.size(), kMaxDescription));
    put_description(out, group.description);
  }
  for (const C3dGroup& group : groups) {
    for (const C3dParameter& parameter : group.parameters) {
      put_parameter(path, group, parameter, out);
    }
  }
  // A name of length zero ends the list.
  const std::size_t blocks = (out.size() + 2 + kBlock - 1) / kBlock;
  out.resize(blocks * kBlock, '\0');
  // Larger sections exist; for them the header's pointer to the data is what counts.
  out[2] = static_cast<char>(std::min<std::size_t>(blocks, 255));
  return out;
}

}  // namespace sinew::c3d
