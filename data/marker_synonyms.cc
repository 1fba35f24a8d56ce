#include "data/marker_synonyms.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string_view>

#include "data/marker_names.h"
#include "data/marker_sets.h"
#include "data/text.h"

namespace sinew {
namespace {

using Index = std::map<std::string, std::string, std::less<>>;  // letters → site

// Of one set, or of all whose names hold always.
struct SiteIndex {
  Index sides, whole;  // letters without side; letters of the whole name

  void add(const MarkerSet& set) {
    for (const MarkerSetRow& row : set.sides) {
      std::istringstream names(row.names);
      for (std::string name; names >> name;) add_side(name, row.site);
    }
    for (const MarkerSetRow& row : set.midline) {
      std::istringstream names(row.names);
      for (std::string name; names >> name;) whole.emplace(name, std::string(":") + row.site);
    }
  }

  std::string site_of(const std::string& name) const;

 private:
  void add_side(const std::string& name, const std::string& site) {
    const std::size_t star = name.find('*');
    if (star == name.npos) {
      sides.emplace(name, site);
      return;
    }
    for (const char* side : {"r", "l"}) {
      std::string letters = name;
      whole.emplace(letters.replace(star, 1, side), std::string(side) + ":" + site);
    }
  }
};

// Separators say nothing: R.Knee.Lat, R_Knee_Lat, `R knee lat`.
std::string letters_of(std::string_view text) {
  std::string letters;
  for (const char c : text) {
    if (std::string_view("._- *").find(c) == std::string_view::npos) letters += c;
  }
  return text::lower(letters);
}

std::string without_subject(const std::string& name) {
  const std::size_t colon = name.rfind(':');
  return colon == name.npos ? name : name.substr(colon + 1);
}

std::string SiteIndex::site_of(const std::string& name) const {
  const std::string bare = without_subject(name);
  const auto found_whole = whole.find(letters_of(bare));
  if (found_whole != whole.end()) return found_whole->second;
  const MarkerName parsed = parse_marker_name(bare);
  if (parsed.side == Side::kNone) {
    // `rasi`, `l asis`: a name in lower case whose first letter makes a site of the rest.
    const std::string letters = letters_of(bare);
    if (letters.size() < 3 || (letters[0] != 'r' && letters[0] != 'l')) return {};
    const auto found = sides.find(letters.substr(1));
    return found == sides.end() ? std::string() : std::string(1, letters[0]) + ":" + found->second;
  }
  const auto found = sides.find(letters_of(parsed.without_side));
  if (found == sides.end()) return {};
  return (parsed.side == Side::kRight ? "r:" : "l:") + found->second;
}

const SiteIndex& common_index() {
  static const SiteIndex index = [] {
    SiteIndex all;
    for (const MarkerSet& set : marker_sets()) {
      if (set.least == 0) all.add(set);
    }
    return all;
  }();
  return index;
}

bool is_recorded(const MarkerSet& set, const std::vector<std::string>& names) {
  std::istringstream words(set.only_together);
  const std::set<std::string> wanted{std::istream_iterator<std::string>(words), {}};
  std::set<std::string> found;
  for (const std::string& name : names) {
    const std::string bare = without_subject(name);
    const MarkerName parsed = parse_marker_name(bare);
    const std::string letters = letters_of(parsed.side == Side::kNone ? bare : parsed.without_side);
    if (wanted.contains(letters)) found.insert(letters);
  }
  return static_cast<int>(found.size()) >= set.least;
}

}  // namespace

bool is_technical_marker(const std::string& name) {
  if (!marker_site(name).empty()) return false;
  const std::string bare = without_subject(name);
  const MarkerName parsed = parse_marker_name(bare);
  std::string letters = letters_of(parsed.side == Side::kNone ? bare : parsed.without_side);
  if (parsed.side == Side::kNone) {
    // `rshank1`; a name without a side is of no limb.
    if (letters.empty() || (letters[0] != 'r' && letters[0] != 'l')) return false;
    letters.erase(0, 1);
  }
  const auto clusters = cluster_names();
  return std::any_of(clusters.begin(), clusters.end(),
                     [&](const char* start) { return letters.starts_with(start); });
}

std::vector<std::string> technical_markers(const std::vector<std::string>& names) {
  std::vector<std::string> technical;
  std::copy_if(names.begin(), names.end(), std::back_inserter(technical), is_technical_marker);
  return technical;
}

std::string marker_site(const std::string& name) { return common_index().site_of(name); }

std::vector<std::string> marker_sites(const std::vector<std::string>& names) {
  std::vector<SiteIndex> recorded;
  for (const MarkerSet& set : marker_sets()) {
    if (set.least == 0 || !is_recorded(set, names)) continue;
    recorded.emplace_back();
    recorded.back().add(set);
  }
  std::vector<std::string> sites;
  for (const std::string& name : names) {
    std::string site;
    for (const SiteIndex& index : recorded) {
      if (site.empty()) site = index.site_of(name);
    }
    sites.push_back(site.empty() ? marker_site(name) : site);
  }
  return sites;
}

std::string joint_centre_site(const std::string& name) {
  const MarkerName parsed = parse_marker_name(without_subject(name));
  if (parsed.side == Side::kNone) return {};
  const std::string letters = letters_of(parsed.without_side);
  for (const char* centre : {"sjc", "ejc", "wjc", "hjc", "kjc", "ajc"}) {
    if (letters == centre) return (parsed.side == Side::kRight ? "r:" : "l:") + letters;
  }
  return {};
}

}  // namespace sinew
