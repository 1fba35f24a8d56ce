#include "data/marker_synonyms.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <sstream>
#include <string_view>

#include "data/marker_names.h"
#include "data/text.h"

namespace sinew {
namespace {

struct Site {
  const char* site;
  const char* names;  // without side, separators and case
};

// Of a side, and below of neither. The first name is the one of the built-in whole body.
constexpr Site kSides[] = {
    {"asi", "asi asis asip iasis"},
    {"psi", "psi psis ipsis"},
    {"sho", "sho shoulder should acromium acromion acr ac acrom shouldertop"},
    {"elb", "elb elbow elblat elbowlat lle lel hle lhe"},
    {"elm", "elm elbmed elbowmed elbowmedial mle mel hme mhe melb medelb"},
    {"wra", "wra faradius wristrad wristmed rsp rad radius wristthumb"},
    {"wrb", "wrb faulna wristuln wristlat usp uln ulna wristpinky"},
    {"fin", "fin finger mc2 hm2"},
    {"gtr", "gtr trc troch trochanter greatertrochanter ftc gt"},
    {"kne", "kne knee kneelat kneelateral lfc lkn fle lek lateralknee latknee lfe lknee"},
    {"knm", "knm kneemed kneemedial mfc mkn fme mek kmed medknee mkne kneem mfe mknee"},
    {"hfb", "hfb fibulahead headfibula fah fhead hof"},
    {"ttc", "ttc ttub tuberosity tibialtuberosity tub"},
    {"ank", "ank ankle anklelat anklelateral lmal lma fal mall latankle lankle latmall llmal lam"},
    {"med", "med anklemed anklemedial mmal mma tam medankle ankm mank mankle mmall medmall mam"},
    {"hee", "hee heel cal calc calcaneus fcc"},
    {"toe", "toe to mt2 met2 2mt smh mth2 toemid"},
    {"mt5", "mt5 met5 5mt toelat vmh mth5 fifthmet"},
    {"mt1", "mt1 met1 1mt toemed fmh mth1 firstmet"},
    {"hlx", "hlx hallux bigtoe"},
    {"fhd", "fhd headfront fronthead"},
    {"bhd", "bhd headback backhead"},
};
constexpr Site kMidline[] = {
    {"sacr", "sacr sacral sacrum vsac vsacral sac s2"},
    {"c7", "c7 c7th cv7"},
    {"t10", "t10 tv10 th10"},
    {"clav", "clav jugular ij clavicle suprasternale sjn"},
    {"strn", "strn xiphoid px xiph xiphoidprocess"},
};

// What names of wands and clusters on a limb begin with, without side, separators and case.
constexpr const char* kTechnical[] = {
    "thi", "thap", "thad", "thl",      "thr", "th1",     "th2", "th3",     "th4",
    "tib", "tiap", "tiad", "sk1",      "sk2", "sk3",     "sk4", "shank",   "shk",
    "sha", "leg",  "upa",  "upperarm", "frm", "forearm", "bak", "cluster", "wand"};

std::map<std::string, std::string, std::less<>> index_of(const auto& sites) {
  std::map<std::string, std::string, std::less<>> index;
  for (const Site& site : sites) {
    std::istringstream names(site.names);
    for (std::string name; names >> name;) index.emplace(name, site.site);
  }
  return index;
}

// Separators say nothing: R.Knee.Lat, R_Knee_Lat, `R knee lat`.
std::string letters_of(std::string_view text) {
  std::string letters;
  for (const char c : text) {
    if (std::string_view("._- *").find(c) == std::string_view::npos) letters += c;
  }
  return text::lower(letters);
}

}  // namespace

bool is_technical_marker(const std::string& name) {
  if (!marker_site(name).empty()) return false;
  const std::size_t colon = name.rfind(':');
  const std::string bare = colon == name.npos ? name : name.substr(colon + 1);
  const MarkerName parsed = parse_marker_name(bare);
  std::string letters = letters_of(parsed.side == Side::kNone ? bare : parsed.without_side);
  if (parsed.side == Side::kNone) {
    // `rshank1`; a name without a side is of no limb.
    if (letters.empty() || (letters[0] != 'r' && letters[0] != 'l')) return false;
    letters.erase(0, 1);
  }
  return std::any_of(std::begin(kTechnical), std::end(kTechnical),
                     [&](const char* start) { return letters.starts_with(start); });
}

std::vector<std::string> technical_markers(const std::vector<std::string>& names) {
  std::vector<std::string> technical;
  std::copy_if(names.begin(), names.end(), std::back_inserter(technical), is_technical_marker);
  return technical;
}

std::string marker_site(const std::string& name) {
  static const auto sides = index_of(kSides), midline = index_of(kMidline);
  const std::size_t colon = name.rfind(':');
  const std::string bare = colon == name.npos ? name : name.substr(colon + 1);
  const auto whole = midline.find(letters_of(bare));
  if (whole != midline.end()) return ":" + whole->second;
  MarkerName parsed = parse_marker_name(bare);
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

}  // namespace sinew
