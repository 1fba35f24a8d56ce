#include "data/marker_names.h"

#include <cctype>
#include <initializer_list>
#include <map>
#include <string_view>

#include "data/text.h"

namespace sinew {
namespace {

struct SideWord {
  const char* word;
  Side side;
};
constexpr SideWord kPrefixes[] = {
    {"left", Side::kLeft}, {"right", Side::kRight}, {"l", Side::kLeft}, {"r", Side::kRight}};
constexpr SideWord kSuffixes[] = {
    {"_left", Side::kLeft}, {"_right", Side::kRight}, {".l", Side::kLeft}, {".r", Side::kRight},
    {"_l", Side::kLeft},    {"_r", Side::kRight},     {"-l", Side::kLeft}, {"-r", Side::kRight},
    {" l", Side::kLeft},    {" r", Side::kRight}};

bool contains_one(std::string_view text, std::initializer_list<const char*> words) {
  for (const char* word : words) {
    if (text.find(word) != text.npos) return true;
  }
  return false;
}

// A single letter is a side only where a name goes on behind it: LASI, R.Heel, L_ankle; not lumbar.
bool letter_is_side(std::string_view name) {
  if (name.size() < 2) return false;
  const auto next = static_cast<unsigned char>(name[1]);
  return std::isupper(next) || std::isdigit(next) ||
         std::string_view("._- ").find(name[1]) != std::string_view::npos;
}

MarkerPlace place_of(std::string_view lower) {
  while (!lower.empty() && std::string_view("._- ").find(lower.front()) != lower.npos) {
    lower.remove_prefix(1);
  }
  if (lower == "to") return MarkerPlace::kFoot;  // R.TOE in systems of four letters
  // Feet before legs: "ankle" and "mal" are as low as heels, to 10 cm.
  if (contains_one(lower, {"hee", "toe", "cal", "mt1", "mt2", "mt5", "mtp", "met", "mal", "ank",
                           "foot", "midfoot", "hlx"})) {
    return MarkerPlace::kFoot;
  }
  if (contains_one(lower, {"hd", "head", "vertex"})) return MarkerPlace::kHead;
  if (contains_one(lower, {"asi", "psi", "sacr", "sacral", "v.sac", "pelvi"})) {
    return MarkerPlace::kPelvis;
  }
  if (contains_one(lower, {"c7", "t10", "clav", "strn", "sternum", "sho", "acr", "offset", "rbak",
                           "rbac"})) {
    return MarkerPlace::kTrunk;
  }
  if (contains_one(lower, {"thi", "th1", "th2", "th3", "kne", "tib", "tb1", "tb2", "tb3", "shank",
                           "lfc", "mfc"})) {
    return MarkerPlace::kLeg;
  }
  return MarkerPlace::kUnknown;
}

}  // namespace

MarkerName parse_marker_name(const std::string& name) {
  MarkerName result;
  const std::size_t colon = name.rfind(':');
  const std::string bare = colon == name.npos ? name : name.substr(colon + 1);
  const std::string lower = text::lower(bare);
  std::string rest = lower;
  for (const auto& [word, side] : kSuffixes) {
    if (!lower.ends_with(word) || result.side != Side::kNone) continue;
    const std::string_view ending(word);
    result.side = side;
    rest = lower.substr(0, lower.size() - ending.size());
    result.without_side = rest + "*";
  }
  for (const auto& [word, side] : kPrefixes) {
    const std::string_view beginning(word);
    if (result.side != Side::kNone || !lower.starts_with(beginning)) continue;
    if (beginning.size() == 1 && !letter_is_side(bare)) continue;
    result.side = side;
    rest = lower.substr(beginning.size());
    result.without_side = "*" + rest;
  }
  result.place = place_of(rest);
  return result;
}

LowAndHighMarkers low_and_high_markers(const std::vector<std::string>& names) {
  LowAndHighMarkers markers;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const MarkerPlace place = parse_marker_name(names[i]).place;
    if (place == MarkerPlace::kFoot) markers.low.push_back(static_cast<int>(i));
    if (place == MarkerPlace::kHead || place == MarkerPlace::kTrunk ||
        place == MarkerPlace::kPelvis) {
      markers.high.push_back(static_cast<int>(i));
    }
  }
  return markers;
}

std::vector<MarkerPair> find_marker_pairs(const std::vector<std::string>& names) {
  std::map<std::string, int> left;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const MarkerName name = parse_marker_name(names[i]);
    if (name.side == Side::kLeft) left.emplace(name.without_side, static_cast<int>(i));
  }
  std::vector<MarkerPair> pairs;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const MarkerName name = parse_marker_name(names[i]);
    const auto found = left.find(name.without_side);
    if (name.side != Side::kRight || found == left.end()) continue;
    pairs.push_back({found->second, static_cast<int>(i)});
  }
  return pairs;
}

}  // namespace sinew
