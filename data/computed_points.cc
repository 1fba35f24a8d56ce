#include "data/computed_points.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <string_view>

#include "data/marker_synonyms.h"
#include "data/numbers.h"
#include "data/statistics.h"
#include "data/text.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

constexpr int kFrames = 100;       // tell as much as all
constexpr int kLeastFrames = 20;   // of two points together
constexpr double kExact = 2e-5;    // [m] of a distance; files round to 1e-5 m, skin moves by 1e-4 m
constexpr double kBetween = 5e-5;  // [m] from the line between two points
constexpr double kNoise = 5e-5;    // [m] of the most constant distance of a marker that is measured
constexpr double kSame = 1e-3;     // [m] no marker is smaller

std::string without_subject(const std::string& name) {
  const std::size_t colon = name.rfind(':');
  return colon == name.npos ? name : name.substr(colon + 1);
}

// One of four points that tell a segment's axes: origin and ends, as PELO, PELA, PELL and PELP.
bool is_axis_point(const std::string& name, const std::vector<std::string>& names) {
  constexpr std::string_view kEnds = "OALP";
  const std::size_t model = name.find("_CGM");
  for (const std::size_t at : {name.size() - 1, model - 1}) {
    if (at >= name.size() || at == 0 || kEnds.find(name[at]) == kEnds.npos) continue;
    const bool all = std::all_of(kEnds.begin(), kEnds.end(), [&](char end) {
      std::string other = name;
      other[at] = end;
      return std::any_of(names.begin(), names.end(),
                         [&](const std::string& there) { return without_subject(there) == other; });
    });
    if (all) return true;
  }
  return false;
}

// VRHI, VLKN, VMID and VPEL are OrthoTrak's; V.Sacral is a marker.
bool is_virtual_name(const std::string& name) {
  if (name == "VMID" || name == "VPEL") return true;
  return name.size() >= 4 && name[0] == 'V' && (name[1] == 'R' || name[1] == 'L') &&
         std::isupper(static_cast<unsigned char>(name[2])) != 0;
}

std::string why_by_name(const std::string& name, const std::vector<std::string>& names) {
  const std::string bare = without_subject(name), lower = text::lower(bare);
  if (bare.empty() || bare[0] == '*' || lower.starts_with("unnamed")) return "nobody named it";
  if (is_axis_point(bare, names)) return "a segment's axis that a program computed";
  if (!joint_centre_site(bare).empty()) return "a joint's centre that a program computed";
  if (is_virtual_name(bare)) return "a point that a program computed";
  for (const char* word : {"centre", "center", "virtual", "jointcent"}) {
    if (lower.find(word) != lower.npos) return "a point that a program computed";
  }
  return {};
}

std::vector<int> some_frames(int count) {
  std::vector<int> frames;
  const int used = std::min(count, kFrames);
  for (int i = 0; i < used; ++i) {
    frames.push_back(used == 1 ? 0 : static_cast<int>(std::int64_t{i} * (count - 1) / (used - 1)));
  }
  return frames;
}

struct Distance {
  double mean = kNaN, sd = mean;
};
Distance distance(const MarkerTrajectories& markers, int a, int b, const std::vector<int>& frames) {
  double sum = 0.0, squares = 0.0;
  int count = 0;
  for (const int f : frames) {
    const double d = (markers.position(f, a) - markers.position(f, b)).norm();
    if (std::isnan(d)) continue;
    sum += d;
    squares += d * d;
    ++count;
  }
  if (count < kLeastFrames) return {};
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean))};
}

// RMS from a point that divides two others in the same ratio in every frame.
double off_the_line(const MarkerTrajectories& markers, int point, int a, int b,
                    const std::vector<int>& frames) {
  double along = 0.0, length = 0.0, count = 0.0;
  for (const int f : frames) {
    const Vector3d ab = markers.position(f, b) - markers.position(f, a),
                   ap = markers.position(f, point) - markers.position(f, a);
    if (!ab.allFinite() || !ap.allFinite()) continue;
    along += ap.dot(ab);
    length += ab.squaredNorm();
    count += 1.0;
  }
  if (count < kLeastFrames || !(length > 0.0)) return std::numeric_limits<double>::infinity();
  const double ratio = along / length;
  double squares = 0.0;
  for (const int f : frames) {
    const Vector3d pa = markers.position(f, a), pb = markers.position(f, b);
    const Vector3d off = markers.position(f, point) - pa - ratio * (pb - pa);
    if (!off.allFinite()) continue;
    squares += off.squaredNorm();
    if (squares > count * kBetween * kBetween) return std::numeric_limits<double>::infinity();
  }
  return std::sqrt(squares / count);
}

class Geometry {
 public:
  explicit Geometry(const MarkerTrajectories& markers)
      : markers_(markers), frames_(some_frames(markers.frame_count())) {
    const int n = markers.marker_count();
    distances_.resize(static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
    for (int a = 0; a < n; ++a) {
      for (int b = 0; b < a; ++b) at(a, b) = at(b, a) = distance(markers, a, b, frames_);
    }
  }

  /// Whether trajectories have noise, so that exact relations tell something: the middle one of
  /// those that `named` leaves.
  bool has_noise(const std::vector<std::string>& named) {
    std::vector<double> least;
    for (int a = 0; a < markers_.marker_count(); ++a) {
      if (!named[static_cast<std::size_t>(a)].empty()) continue;
      double sd = std::numeric_limits<double>::infinity();
      for (int b = 0; b < markers_.marker_count(); ++b) {
        if (a == b || !named[static_cast<std::size_t>(b)].empty()) continue;
        if (at(a, b).mean > kSame) sd = std::min(sd, at(a, b).sd);
      }
      if (std::isfinite(sd)) least.push_back(sd);
    }
    return !least.empty() && median(std::move(least)) > kNoise;
  }

  std::string why(int point, const std::vector<std::string>& named) {
    const int n = markers_.marker_count();
    for (int other = 0; other < n; ++other) {
      if (other == point) continue;
      const Distance& d = at(point, other);
      const std::string& name = markers_.names[static_cast<std::size_t>(other)];
      if (d.mean < kSame && (other < point || named[static_cast<std::size_t>(other)].empty())) {
        return "in one place with " + name;
      }
      // What a program computed keeps its distance to the marker that it follows; so does that.
      if (d.mean >= kSame && d.sd < kExact && named[static_cast<std::size_t>(other)].empty()) {
        return "computed: it keeps its distance to " + name + " to 0.02 mm";
      }
    }
    for (int a = 0; a < n; ++a) {
      for (int b = 0; b < a; ++b) {
        if (a == point || b == point || at(a, b).mean < kSame) continue;
        if (!named[static_cast<std::size_t>(a)].empty()) break;
        if (!named[static_cast<std::size_t>(b)].empty()) continue;
        if (off_the_line(markers_, point, a, b, frames_) < kBetween) {
          return "computed: it lies between " + markers_.names[static_cast<std::size_t>(b)] +
                 " and " + markers_.names[static_cast<std::size_t>(a)] + " to 0.05 mm";
        }
      }
    }
    return {};
  }

 private:
  Distance& at(int a, int b) {
    return distances_[static_cast<std::size_t>(a) *
                          static_cast<std::size_t>(markers_.marker_count()) +
                      static_cast<std::size_t>(b)];
  }

  const MarkerTrajectories& markers_;
  std::vector<int> frames_;
  std::vector<Distance> distances_;
};

}  // namespace

std::vector<std::string> why_no_marker(const MarkerTrajectories& markers) {
  std::vector<std::string> named;
  for (const std::string& name : markers.names) {
    named.push_back(why_by_name(name, markers.names));
  }
  Geometry geometry(markers);
  if (!geometry.has_noise(named)) return named;
  std::vector<std::string> reasons = named;
  for (int i = 0; i < markers.marker_count(); ++i) {
    std::string& reason = reasons[static_cast<std::size_t>(i)];
    if (reason.empty()) reason = geometry.why(i, named);
  }
  return reasons;
}

}  // namespace sinew
