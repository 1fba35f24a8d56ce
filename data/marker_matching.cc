#include "data/marker_matching.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <numeric>
#include <set>
#include <string_view>

#include "data/marker_synonyms.h"
#include "data/text.h"

namespace sinew {
namespace {

std::string subject_of(const std::string& name) {
  const std::size_t colon = name.rfind(':');
  return colon == name.npos ? "" : name.substr(0, colon);
}

std::string without_subject(const std::string& name) {
  const std::size_t colon = name.rfind(':');
  return colon == name.npos ? name : name.substr(colon + 1);
}

// Without case, blanks and separators.
std::string spelling_of(const std::string& name) {
  std::string letters;
  for (const char c : without_subject(name)) {
    if (std::string_view("._- ").find(c) == std::string_view::npos) letters += c;
  }
  return text::lower(letters);
}

std::string some_of(const std::vector<std::string>& names, std::size_t most) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  if (names.size() > most) text += fmt::format(" and {} more", names.size() - most);
  return text;
}

class Matcher {
 public:
  Matcher(const std::vector<std::string>& recorded, const std::vector<std::string>& model,
          const std::string& path)
      : recorded_(recorded),
        model_(model),
        path_(path),
        recorded_sites_(marker_sites(recorded)),
        model_sites_(marker_sites(model)),
        taken_recorded_(recorded.size(), false),
        taken_model_(model.size(), false) {
    for (std::size_t m = 0; m < model.size(); ++m) {
      if (model_sites_[m].empty()) model_sites_[m] = joint_centre_site(model[m]);
    }
  }

  MarkerMatching match(const MarkerMap& map, const std::string& subject) {
    result_.subject = subject;
    for (std::size_t i = 0; i < recorded_.size(); ++i) {
      if (subject_of(recorded_[i]) != subject && !subject.empty()) taken_recorded_[i] = true;
    }
    const std::vector<bool> others = taken_recorded_;
    for (const auto& [from, to] : map) apply(from, to);
    pair_by(MatchKind::kSame, keys_of(recorded_, without_subject), model_);
    pair_by(MatchKind::kSpelling, keys_of(recorded_, spelling_of), keys_of(model_, spelling_of));
    pair_by(MatchKind::kSite, recorded_sites_, model_sites_);
    std::sort(result_.matches.begin(), result_.matches.end(),
              [](const MarkerMatch& a, const MarkerMatch& b) { return a.recorded < b.recorded; });
    std::vector<bool> used = others;
    for (const MarkerMatch& match : result_.matches) {
      used[static_cast<std::size_t>(match.recorded)] = true;
    }
    result_.unused = indices_of_false(used);
    result_.missing = indices_of_false(taken_model_);
    return std::move(result_);
  }

 private:
  static std::vector<int> indices_of_false(const std::vector<bool>& flags) {
    std::vector<int> indices;
    for (std::size_t i = 0; i < flags.size(); ++i) {
      if (!flags[i]) indices.push_back(static_cast<int>(i));
    }
    return indices;
  }

  // The recorded marker that a map names, with or without its subject.
  std::size_t recorded_named(const std::string& name) const {
    for (std::size_t i = 0; i < recorded_.size(); ++i) {
      if (recorded_[i] == name) return i;
    }
    for (std::size_t i = 0; i < recorded_.size(); ++i) {
      const bool mine = result_.subject.empty() || subject_of(recorded_[i]) == result_.subject;
      if (mine && without_subject(recorded_[i]) == name) return i;
    }
    throw InputError({path_}, {fmt::format("has no marker '{}', which the map names", name),
                               nearest_name(name, recorded_), "", "Correct the map."});
  }

  void apply(const std::string& from, const std::string& to) {
    const std::size_t recorded = recorded_named(from);
    taken_recorded_[recorded] = true;
    if (to.empty()) return;
    const auto found = std::find(model_.begin(), model_.end(), to);
    if (found == model_.end()) {
      throw InputError({path_},
                       {fmt::format("the model has no marker '{}', which the map names", to),
                        nearest_name(to, model_), "", "Correct the map."});
    }
    take(recorded, static_cast<std::size_t>(found - model_.begin()), MatchKind::kSaid);
  }

  void take(std::size_t recorded, std::size_t model, MatchKind kind) {
    taken_recorded_[recorded] = taken_model_[model] = true;
    result_.matches.push_back({static_cast<int>(recorded), static_cast<int>(model), kind});
  }

  template <typename Key>
  static std::vector<std::string> keys_of(const std::vector<std::string>& names, const Key& key) {
    std::vector<std::string> keys;
    std::transform(names.begin(), names.end(), std::back_inserter(keys), key);
    return keys;
  }

  // A key point RKnee is no epicondyle R.Knee, whatever the spelling.
  bool contradict(std::size_t recorded, std::size_t model) const {
    return !recorded_sites_[recorded].empty() && !model_sites_[model].empty() &&
           recorded_sites_[recorded] != model_sites_[model];
  }

  void pair_by(MatchKind kind, const std::vector<std::string>& recorded_keys,
               const std::vector<std::string>& model_keys) {
    std::map<std::string, std::size_t> models;
    for (std::size_t m = 0; m < model_.size(); ++m) {
      if (!taken_model_[m] && !model_keys[m].empty()) models.emplace(model_keys[m], m);
    }
    for (std::size_t i = 0; i < recorded_.size(); ++i) {
      if (taken_recorded_[i]) continue;
      const auto found = models.find(recorded_keys[i]);
      if (found == models.end() || taken_model_[found->second]) continue;
      if (contradict(i, found->second)) continue;
      take(i, found->second, kind);
    }
  }

  const std::vector<std::string>& recorded_;
  const std::vector<std::string>& model_;
  const std::string& path_;
  std::vector<std::string> recorded_sites_, model_sites_;
  std::vector<bool> taken_recorded_, taken_model_;
  MarkerMatching result_;
};

std::vector<std::string> subjects_of(const std::vector<std::string>& recorded) {
  std::vector<std::string> subjects;
  for (const std::string& name : recorded) {
    const std::string subject = subject_of(name);
    if (subject.empty()) continue;
    if (std::find(subjects.begin(), subjects.end(), subject) == subjects.end()) {
      subjects.push_back(subject);
    }
  }
  return subjects;
}

std::size_t edits(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t k = 0; k < b.size(); ++k) {
      const std::size_t replaced = diagonal + (a[i] == b[k] ? 0 : 1);
      diagonal = row[k + 1];
      row[k + 1] = std::min({row[k] + 1, row[k + 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

}  // namespace

const char* to_string(MatchKind kind) {
  switch (kind) {
    case MatchKind::kSaid:
      return "said";
    case MatchKind::kSame:
      return "same name";
    case MatchKind::kSpelling:
      return "same but for case and separators";
    default:
      return "same place in another marker set";
  }
}

int MarkerMatching::count(MatchKind kind) const {
  return static_cast<int>(std::count_if(matches.begin(), matches.end(),
                                        [&](const MarkerMatch& m) { return m.kind == kind; }));
}

MarkerMatching match_markers(const std::vector<std::string>& recorded,
                             const std::vector<std::string>& model, const MatchingOptions& options,
                             const std::string& path) {
  const std::vector<std::string> subjects = subjects_of(recorded);
  const auto with = [&](const std::string& subject) {
    MarkerMatching result = Matcher(recorded, model, path).match(options.map, subject);
    result.subjects = subjects;
    return result;
  };
  if (!options.subject.empty()) {
    if (std::find(subjects.begin(), subjects.end(), options.subject) == subjects.end()) {
      throw InputError({path}, {"has no markers of that subject",
                                subjects.empty() ? "names without subjects" : some_of(subjects, 8),
                                options.subject, "Correct --subject or leave it out."});
    }
    return with(options.subject);
  }
  if (subjects.empty()) return with("");
  MarkerMatching best = with(subjects.front());
  for (std::size_t i = 1; i < subjects.size(); ++i) {
    MarkerMatching next = with(subjects[i]);
    if (next.matches.size() > best.matches.size()) best = std::move(next);
  }
  return best;
}

void require_matches(const MarkerMatching& matching, int least,
                     const std::vector<std::string>& recorded,
                     const std::vector<std::string>& model, const std::string& path) {
  if (static_cast<int>(matching.matches.size()) >= least) return;
  std::vector<std::string> free;
  for (const int m : matching.missing) free.push_back(model[static_cast<std::size_t>(m)]);
  std::vector<std::string> pairs;
  for (const int i : matching.unused) {
    const std::string& name = recorded[static_cast<std::size_t>(i)];
    const std::string nearest = nearest_name(name, free);
    pairs.push_back(nearest.empty() ? name : fmt::format("{} ({}?)", name, nearest));
  }
  throw InputError(
      {path},
      {fmt::format("only {} of {} recorded markers have a name that the model knows; not used: {}; "
                   "the model's: {}",
                   matching.matches.size(), matching.matches.size() + matching.unused.size(),
                   some_of(pairs, 60), some_of(free, 60)),
       fmt::format("{} or more", least), "",
       "Give --map MAP.csv with lines `recorded,model`, or a model with these markers."});
}

MarkerTrajectories rename_markers(const MarkerTrajectories& markers, const MarkerMatching& matching,
                                  const std::vector<std::string>& model) {
  std::vector<std::pair<int, std::string>> kept;  // index and name
  std::set<std::string> names;
  for (const MarkerMatch& match : matching.matches) {
    kept.emplace_back(match.recorded, model[static_cast<std::size_t>(match.model)]);
    names.insert(kept.back().second);
  }
  for (const int i : matching.unused) {
    std::string name = without_subject(markers.names[static_cast<std::size_t>(i)]);
    while (!names.insert(name).second) name += "_recorded";
    kept.emplace_back(i, name);
  }
  std::sort(kept.begin(), kept.end());
  MarkerTrajectories result;
  result.rate = markers.rate;
  result.frame_numbers = markers.frame_numbers;
  result.time = markers.time;
  result.p_WM.resize(markers.frame_count(), static_cast<Eigen::Index>(3 * kept.size()));
  for (std::size_t i = 0; i < kept.size(); ++i) {
    result.names.push_back(kept[i].second);
    result.p_WM.middleCols<3>(static_cast<Eigen::Index>(3 * i)) =
        markers.p_WM.middleCols<3>(3 * kept[i].first);
  }
  return result;
}

std::string nearest_name(const std::string& name, const std::vector<std::string>& names) {
  const std::string mine = spelling_of(name);
  std::string best;
  std::size_t least = mine.size() / 2 + 1;
  for (const std::string& other : names) {
    const std::size_t count = edits(mine, spelling_of(other));
    if (count >= least) continue;
    least = count;
    best = other;
  }
  return best;
}

}  // namespace sinew
