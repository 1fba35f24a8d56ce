#include "data/preflight_swaps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <tuple>

#include "data/marker_names.h"
#include "data/preflight_sides.h"
#include "data/statistics.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// Follows markers, each through the columns that it was found in.
class Follower {
 public:
  Follower(const MarkerTrajectories& markers, const SwapCheckOptions& options)
      : markers_(markers),
        options_(options),
        usual_(static_cast<std::size_t>(markers.marker_count()), 0.0),
        columns_(usual_.size()),
        tracks_(usual_.size()) {
    std::iota(columns_.begin(), columns_.end(), 0);
    for (int i = 0; i < markers.marker_count(); ++i) usual_[index(i)] = usual_error(i);
  }

  std::vector<MarkerSwap> follow() {
    for (int frame = 0; frame < markers_.frame_count(); ++frame) {
      exchange_jumping(frame);
      for (std::size_t i = 0; i < tracks_.size(); ++i) advance(i, frame);
    }
    for (MarkerSwap& swap : open_) close_at_end(swap);
    std::sort(found_.begin(), found_.end(), [](const MarkerSwap& x, const MarkerSwap& y) {
      return std::tie(x.first, x.a, x.b) < std::tie(y.first, y.a, y.b);
    });
    return std::move(found_);
  }

 private:
  struct Track {
    int last = -1;                  // frame it was last measured in
    Vector3d p = Vector3d::Zero();  // there
    Vector3d v = Vector3d::Zero();  // by the step before [m per frame]
    bool moving = false;            // v is known
  };
  struct Jump {
    std::size_t track;
    Vector3d expected, landed;
    double length;
  };

  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  // The middle distance of a sample from the line through the two before it.
  double usual_error(int marker) const {
    std::vector<double> errors;
    for (int f = 2; f < markers_.frame_count(); ++f) {
      const double e = (markers_.position(f, marker) - 2.0 * markers_.position(f - 1, marker) +
                        markers_.position(f - 2, marker))
                           .norm();
      if (std::isfinite(e)) errors.push_back(e);
    }
    return errors.empty() ? 0.0 : median(std::move(errors));
  }

  double least_jump(std::size_t track) const {
    return std::max(options_.least_jump, options_.times_usual * usual_[track]);
  }

  std::vector<Jump> jumps_at(int frame) const {
    std::vector<Jump> jumps;
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      const Track& track = tracks_[i];
      const Vector3d p = markers_.position(frame, columns_[i]);
      const int steps = frame - track.last;
      if (!track.moving || !p.allFinite() || steps > longest_steps()) continue;
      const Vector3d expected = track.p + steps * track.v;
      const double length = (p - expected).norm();
      if (length > steps * least_jump(i)) jumps.push_back({i, expected, p, length});
    }
    return jumps;
  }

  int longest_steps() const {
    return 1 + static_cast<int>(std::lround(options_.longest_gap * markers_.rate));
  }

  void exchange_jumping(int frame) {
    std::vector<Jump> jumps = jumps_at(frame);
    while (jumps.size() > 1) {
      double best = options_.most_left;
      std::size_t x = 0, y = 0;
      for (std::size_t i = 0; i < jumps.size(); ++i) {
        for (std::size_t k = i + 1; k < jumps.size(); ++k) {
          const double left = ((jumps[i].landed - jumps[k].expected).norm() +
                               (jumps[k].landed - jumps[i].expected).norm()) /
                              (jumps[i].length + jumps[k].length);
          if (left >= best) continue;
          best = left;
          x = i;
          y = k;
        }
      }
      if (x == y) return;
      record(frame, jumps[x], jumps[y], best);
      std::swap(columns_[jumps[x].track], columns_[jumps[y].track]);
      jumps.erase(jumps.begin() + static_cast<std::ptrdiff_t>(y));
      jumps.erase(jumps.begin() + static_cast<std::ptrdiff_t>(x));
    }
  }

  void record(int frame, const Jump& x, const Jump& y, double left) {
    MarkerSwap swap;
    std::tie(swap.a, swap.b) = std::minmax({columns_[x.track], columns_[y.track]});
    swap.first = frame;
    swap.jump = 0.5 * (x.length + y.length);
    swap.left = left;
    const auto same = std::find_if(open_.begin(), open_.end(), [&](const MarkerSwap& o) {
      return o.a == swap.a && o.b == swap.b;
    });
    if (same == open_.end()) {
      open_.push_back(swap);
      return;
    }
    same->last = frame - 1;
    same->left = std::max(same->left, left);
    found_.push_back(*same);
    open_.erase(same);
  }

  void close_at_end(MarkerSwap& swap) {
    const int frames = markers_.frame_count();
    swap.undone = false;
    swap.last = frames - 1;
    if (2 * swap.first < frames) {
      swap.last = swap.first - 1;
      swap.first = 0;
    }
    found_.push_back(swap);
  }

  void advance(std::size_t i, int frame) {
    Track& track = tracks_[i];
    const Vector3d p = markers_.position(frame, columns_[i]);
    if (!p.allFinite()) return;
    const int steps = frame - track.last;
    track.moving = track.last >= 0 && steps <= longest_steps();
    if (track.moving) track.v = (p - track.p) / steps;
    track.p = p;
    track.last = frame;
  }

  const MarkerTrajectories& markers_;
  const SwapCheckOptions& options_;
  std::vector<double> usual_;
  std::vector<int> columns_;
  std::vector<Track> tracks_;
  std::vector<MarkerSwap> open_, found_;
};

// In which part of some frames two markers lie as their names forbid; NaN where nothing tells.
using Against = std::function<double(int first, int end)>;

double share_of(int first, int end, const std::function<double(int)>& vote) {
  int against = 0, count = 0;
  for (int frame = first; frame < end; ++frame) {
    const double v = vote(frame);
    if (!(v != 0.0)) continue;
    ++count;
    against += v < 0.0;
  }
  return count == 0 ? std::nan("") : static_cast<double>(against) / count;
}

// A left and a right marker against the other pairs.
Against against_other_pairs(const MarkerTrajectories& markers, int left, int right,
                            const Vector3d& up) {
  std::vector<MarkerPair> others = find_marker_pairs(markers.names);
  std::erase_if(others, [&](const MarkerPair& pair) {
    return pair.left == left || pair.left == right || pair.right == left || pair.right == right;
  });
  return [&markers, left, right, up, others](int first, int end) {
    return share_of(first, end, [&](int frame) {
      Vector3d sum = Vector3d::Zero();
      for (const MarkerPair& pair : others) sum += rightward(markers, frame, pair, up);
      return rightward(markers, frame, {left, right}, up).dot(sum);
    });
  };
}

Against against_heights(const MarkerTrajectories& markers, int high, int low, const Vector3d& up) {
  return [&markers, high, low, up](int first, int end) {
    return share_of(first, end, [&](int frame) {
      const double d = up.dot(markers.position(frame, high) - markers.position(frame, low));
      return std::isfinite(d) ? d : 0.0;
    });
  };
}

Against names_against(const MarkerTrajectories& markers, const MarkerSwap& swap,
                      const Vector3d& up) {
  const MarkerName a = parse_marker_name(markers.names[static_cast<std::size_t>(swap.a)]);
  const MarkerName b = parse_marker_name(markers.names[static_cast<std::size_t>(swap.b)]);
  // From top to toe, as they are declared.
  if (a.place != b.place && a.place != MarkerPlace::kUnknown && b.place != MarkerPlace::kUnknown) {
    return a.place < b.place ? against_heights(markers, swap.a, swap.b, up)
                             : against_heights(markers, swap.b, swap.a, up);
  }
  if (a.side == Side::kLeft && b.side == Side::kRight) {
    return against_other_pairs(markers, swap.a, swap.b, up);
  }
  if (a.side == Side::kRight && b.side == Side::kLeft) {
    return against_other_pairs(markers, swap.b, swap.a, up);
  }
  return [](int, int) { return std::nan(""); };
}

struct Part {
  int first = 0, end = 0;
};

// What is exchanged; nothing where that cannot be told.
std::optional<Part> exchanged_part(const MarkerTrajectories& markers, const MarkerSwap& swap,
                                   const LaboratoryAxes& axes) {
  constexpr double kClear = 0.8;     // feet that cross do so for less than half of a stride
  constexpr double kShorter = 0.25;  // of the record
  const Part given{swap.first, swap.last + 1};
  if (swap.undone) return given;
  const int frames = markers.frame_count();
  const Part other = swap.first == 0 ? Part{given.end, frames} : Part{0, given.first};
  if (axes.up.known()) {
    const Against against = names_against(markers, swap, axes.up.axis);
    const double here = against(given.first, given.end), there = against(other.first, other.end);
    if (here > kClear && there < 1.0 - kClear) return given;
    if (there > kClear && here < 1.0 - kClear) return other;
  }
  if (given.end - given.first < kShorter * frames) return given;
  return {};
}

std::string swap_option(const MarkerTrajectories& markers, const MarkerSwap& swap, double from,
                        double to) {
  return fmt::format("{},{}@{}-{}", markers.names[static_cast<std::size_t>(swap.a)],
                     markers.names[static_cast<std::size_t>(swap.b)], time_text(from),
                     time_text(to));
}

}  // namespace

void SwapCheckOptions::validate() const {
  const auto require = [](const char* name, double value, bool fine, const char* bound) {
    if (fine) return;
    throw std::invalid_argument(
        fmt::format("SwapCheckOptions::{} is {}; it must be {}", name, value, bound));
  };
  require("least_jump", least_jump, least_jump > 0.0, "above 0");
  require("times_usual", times_usual, times_usual >= 1.0, "at least 1");
  require("most_left", most_left, most_left > 0.0 && most_left < 1.0, "between 0 and 1");
  require("longest_gap", longest_gap, longest_gap >= 0.0, "at least 0");
}

std::vector<MarkerSwap> find_marker_swaps(const MarkerTrajectories& markers,
                                          const SwapCheckOptions& options) {
  options.validate();
  return Follower(markers, options).follow();
}

Finding whole_exchange(const std::string& a, const std::string& b, const std::string& why) {
  Finding finding;
  finding.severity = Finding::Severity::kError;
  finding.kind = "swap";
  finding.where = a + ", " + b;
  finding.confidence = 0.95;
  finding.text = why + ": they bear each other's names";
  finding.flags = {"--swap", a + "," + b};
  return finding;
}

std::vector<Finding> find_swap_faults(const MarkerTrajectories& markers, const LaboratoryAxes& axes,
                                      const SwapCheckOptions& options) {
  std::vector<Finding> findings;
  for (const MarkerSwap& swap : find_marker_swaps(markers, options)) {
    const std::string& a = markers.names[static_cast<std::size_t>(swap.a)];
    const std::string& b = markers.names[static_cast<std::size_t>(swap.b)];
    Finding finding;
    finding.severity = Finding::Severity::kError;
    finding.kind = "swap";
    finding.where = a + ", " + b;
    const std::optional<Part> part = exchanged_part(markers, swap, axes);
    const Part named = part.value_or(Part{swap.first, swap.last + 1});
    set_frames(finding, markers, named.first, named.end - 1);
    finding.confidence = std::clamp(1.0 - swap.left, 0.5, 0.99);
    finding.text = fmt::format(
        "both jump by {:.0f} mm, each to where the other was about to be: they bear each other's "
        "names",
        1e3 * swap.jump);
    if (part) {
      finding.flags = {"--swap", swap_option(markers, swap, finding.from, finding.to)};
    } else {
      const int begin = swap.first == 0 ? swap.last + 1 : swap.first;
      const Eigen::VectorXd& t = markers.time;
      finding.text += " before or from then on";
      finding.advice =
          fmt::format("nothing tells which part is right: --swap {} or --swap {}",
                      swap_option(markers, swap, t[0], t[begin - 1]),
                      swap_option(markers, swap, t[begin], t[markers.frame_count() - 1]));
    }
    findings.push_back(std::move(finding));
  }
  return findings;
}

}  // namespace sinew
