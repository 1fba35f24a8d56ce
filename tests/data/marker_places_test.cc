// Names of all published recordings against where their markers are.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>

#include "data/c3d_reader.h"
#include "data/marker_matching.h"
#include "data/marker_synonyms.h"
#include "data/trc_file.h"
#include "tests/data/test_files.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

// Mean place of each site over the frames in which front of the pelvis and both ankles are seen,
// along up and to the right of the subject.
class Places {
 public:
  Places(const MarkerTrajectories& markers, const std::string& file) {
    const std::vector<std::string> sites = marker_sites(markers.names);
    for (std::size_t i = 0; i < sites.size(); ++i) {
      if (sites[i].empty()) continue;
      const bool is_new = columns_.emplace(sites[i], static_cast<int>(i)).second;
      EXPECT_TRUE(is_new) << file << ": " << markers.names[i] << " is a second " << sites[i];
    }
    if (!has("r:asi") || !has("l:asi") || !has("r:ank") || !has("l:ank")) return;
    int count = 0;
    for (int f = 0; f < markers.frame_count(); ++f) {
      const Vector3d right = at(markers, f, "r:asi") - at(markers, f, "l:asi"),
                     up = 0.5 * (at(markers, f, "r:asi") + at(markers, f, "l:asi") -
                                 at(markers, f, "r:ank") - at(markers, f, "l:ank"));
      if (!right.allFinite() || !up.allFinite()) continue;
      ++count;
      for (const auto& [site, column] : columns_) {
        const Vector3d p = markers.position(f, column);
        if (!p.allFinite()) continue;
        Sum& sum = sums_[site];
        sum.high += p.dot(up.normalized());
        sum.right += (p - at(markers, f, "l:asi")).dot(right.normalized());
        ++sum.count;
      }
    }
    usable_ = count > 5;
  }

  bool usable() const { return usable_; }
  bool seen(const std::string& site) const { return sums_.contains(site); }
  double high(const std::string& site) const {
    const Sum& sum = sums_.at(site);
    return sum.high / sum.count;
  }
  double right(const std::string& site) const {
    const Sum& sum = sums_.at(site);
    return sum.right / sum.count;
  }

 private:
  struct Sum {
    double high = 0.0, right = 0.0;
    int count = 0;
  };
  bool has(const std::string& site) const { return columns_.contains(site); }
  Vector3d at(const MarkerTrajectories& markers, int frame, const std::string& site) const {
    return markers.position(frame, columns_.at(site));
  }

  std::map<std::string, int> columns_;
  std::map<std::string, Sum> sums_;
  bool usable_ = false;
};

// A name that means another place shows in the order of heights, sides and medial markers.
void expect_body(const Places& places, const std::string& file) {
  for (const std::string side : {"r:", "l:"}) {
    std::string below;
    for (const char* site : {"ank", "kne", "asi", "sho"}) {
      if (!places.seen(side + site)) continue;
      if (!below.empty()) {
        EXPECT_GT(places.high(side + site), places.high(below)) << file << " " << side << site;
      }
      below = side + site;
    }
    // Of arms that are turned anyhow nothing is known.
    for (const auto& [medial, lateral] : {std::pair{"knm", "kne"}, std::pair{"med", "ank"}}) {
      if (!places.seen(side + medial) || !places.seen(side + lateral)) continue;
      const double out = side == "r:" ? 1.0 : -1.0;
      EXPECT_GT(out * (places.right(side + lateral) - places.right(side + medial)), 0.0)
          << file << " " << side << medial;
      EXPECT_NEAR(places.high(side + lateral), places.high(side + medial), 0.06) << file;
    }
    for (const char* site : {"hee", "toe", "mt1", "mt5"}) {
      if (places.seen(side + site) && places.seen(side + "kne")) {
        EXPECT_LT(places.high(side + site), places.high(side + "kne") - 0.1) << file << site;
      }
    }
  }
  for (const char* site : {"ank", "kne", "knm", "sho", "gtr", "psi", "elb"}) {
    const std::string r = std::string("r:") + site, l = std::string("l:") + site;
    if (!places.seen(r) || !places.seen(l)) continue;
    EXPECT_GT(places.right(r), places.right(l)) << file << " " << site;
  }
}

TEST(MarkerPlaces, NamesOfAllRecordingsMeanWhereTheMarkersAre) {
  const fs::path shared = fs::absolute("../shared/data");
  if (!fs::exists(shared)) GTEST_SKIP() << "no ../shared/data";
  int looked_at = 0;
  for (const auto& entry : fs::recursive_directory_iterator(shared)) {
    std::string extension = entry.path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    MarkerTrajectories markers;
    try {
      if (extension == ".c3d") markers = read_c3d(entry.path()).markers;
      if (extension == ".trc") markers = read_trc(entry.path()).markers;
    } catch (const InputError&) {
      continue;  // told of elsewhere
    }
    if (markers.frame_count() == 0) continue;
    const Places places(markers, entry.path().filename().string());
    if (!places.usable()) continue;
    ++looked_at;
    expect_body(places, entry.path().filename().string());
  }
  EXPECT_GE(looked_at, 20);
}

}  // namespace
}  // namespace sinew
