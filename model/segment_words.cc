#include "model/segment_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

#include "data/text.h"

namespace sinew {
namespace {

struct Part {
  const char* part;
  const char* word;  // that a body's name contains
};

// In order: the first that fits counts.
constexpr Part kParts[] = {
    {"pelvis", "pelv"},        {"pelvis", "sacrum"},    {"thigh", "femur"},
    {"thigh", "thigh"},        {"knee cap", "patella"}, {"shank", "tibia"},
    {"shank", "fibula"},       {"shank", "shank"},      {"foot", "calcn"},
    {"foot", "talus"},         {"foot", "toe"},         {"foot", "foot"},
    {"foot", "hallux"},        {"foot", "tars"},        {"trunk", "scapula"},
    {"trunk", "clavicle"},     {"upper arm", "humer"},  {"upper arm", "upper_arm"},
    {"upper arm", "upperarm"}, {"forearm", "ulna"},     {"forearm", "radius"},
    {"forearm", "forearm"},    {"hand", "hand"},        {"hand", "carp"},
    {"hand", "finger"},        {"hand", "index"},       {"hand", "middle"},
    {"hand", "ring"},          {"hand", "little"},      {"hand", "thumb"},
    {"head", "skull"},         {"head", "head"},        {"head", "cervical"},
    {"trunk", "torso"},        {"trunk", "thorax"},     {"trunk", "trunk"},
    {"trunk", "lumbar"},       {"trunk", "sternum"},    {"trunk", "abdomen"},
    {"trunk", "spine"}};

// Vertebrae: L1 to L5, T1 to T12, C1 to C7, of any case.
const char* vertebra_part(std::string_view name) {
  if (name.size() < 2 || name.size() > 3) return nullptr;
  if (!std::all_of(name.begin() + 1, name.end(),
                   [](unsigned char c) { return std::isdigit(c) != 0; })) {
    return nullptr;
  }
  if (name[0] == 'l' || name[0] == 't') return "trunk";
  return name[0] == 'c' ? "head" : nullptr;
}

}  // namespace

Segment segment_of_body(const std::string& body) {
  const std::string lower = text::lower(body);
  if (const char* part = vertebra_part(lower)) return {part, Side::kNone, true};
  const Side side = parse_marker_name(body).side;
  for (const auto& [part, word] : kParts) {
    if (lower.find(word) == lower.npos) continue;
    // Shoulder blades and collar bones come in pairs, the trunk does not.
    const bool midline = std::string_view(part) == "trunk" || std::string_view(part) == "head" ||
                         std::string_view(part) == "pelvis";
    return {part, midline ? Side::kNone : side, true};
  }
  return {body, Side::kNone, false};
}

std::string segments_in_words(const std::vector<Segment>& segments) {
  std::vector<std::string> words;
  std::vector<Segment> done;
  for (const Segment& segment : segments) {
    if (std::find(done.begin(), done.end(), segment) != done.end()) continue;
    done.push_back(segment);
    Segment other = segment;
    other.side = segment.side == Side::kLeft ? Side::kRight : Side::kLeft;
    const bool both = segment.side != Side::kNone &&
                      std::find(segments.begin(), segments.end(), other) != segments.end();
    if (both) {
      done.push_back(other);
      words.push_back("both " + (segment.part == "foot" ? "feet" : segment.part + "s"));
    } else if (!segment.known) {
      words.push_back(fmt::format("the segment '{}'", segment.part));
    } else {
      words.push_back(fmt::format("the {}{}",
                                  segment.side == Side::kLeft    ? "left "
                                  : segment.side == Side::kRight ? "right "
                                                                 : "",
                                  segment.part));
    }
  }
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " and " : ", ";
    text += words[i];
  }
  return text;
}

}  // namespace sinew
