#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "data/c3d_labels.h"
#include "data/force_platform.h"
#include "data/text.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// Platforms are 0.2 to 3 m long; treadmills and walkways the longest.
constexpr double kMinSide = 0.05, kMaxSide = 10.0;  // [m]
// Corners are measured with markers, to about a centimetre.
constexpr double kMaxSideDifference = 0.2;  // of the longer side
constexpr double kMaxCosine = 0.2;          // between sides
// Farther from the origin of the laboratory there is none.
constexpr double kMaxDistance = 100.0;  // [m]

// N or N·m in a unit as channels name it: "N", "nt", "Newtons", "Nmm", "ntmm", "N-M", "N.m", ...
std::optional<double> newtons_per(const std::string& unit, bool moment) {
  std::string lower;
  for (const char c : text::lower(unit)) {
    if (std::isalpha(static_cast<unsigned char>(c))) lower += c;
  }
  for (const char* word : {"newtons", "newton", "nt", "n"}) {
    if (!lower.starts_with(word)) continue;
    const std::string rest = lower.substr(std::string(word).size());
    if (!moment) return rest.empty() ? std::optional<double>(1.0) : std::nullopt;
    if (rest.empty()) return std::nullopt;
    return c3d::metres_per(rest);
  }
  return std::nullopt;
}

std::size_t channel_count(int type) {
  if (type == 6) return 12;
  return type == 3 || type == 5 || type == 7 ? 8 : 6;
}

// Whether ORIGIN says where four transducers stand.
bool has_four_transducers(int type) { return type == 3 || type == 6 || type == 7; }

class Finder {
 public:
  Finder(const C3dFile& file, std::vector<Warning>& warnings)
      : file_(file),
        warnings_(warnings),
        corners_(numbers("CORNERS")),
        origins_(numbers("ORIGIN")),
        types_(numbers("TYPE")) {}

  std::vector<ForcePlatform> find() {
    // As many as bytes can count.
    const double used =
        std::clamp(find_number(file_.groups, "FORCE_PLATFORM", "USED").value_or(0.0), 0.0, 255.0);
    std::vector<ForcePlatform> platforms;
    for (int i = 0; i < static_cast<int>(used); ++i) {
      ForcePlatform platform;
      platform.number = i + 1;
      fill(platform, static_cast<std::size_t>(i));
      if (!platform.usable()) warn(platform, platform.problem);
      platforms.push_back(std::move(platform));
    }
    return platforms;
  }

 private:
  std::vector<double> numbers(const char* name) const {
    return find_numbers(file_.groups, "FORCE_PLATFORM", name);
  }
  void warn(const ForcePlatform& platform, const std::string& text) {
    warnings_.push_back(
        {{file_.path, 0}, fmt::format("force platform {}: {}", platform.number, text)});
  }

  void fill(ForcePlatform& platform, std::size_t i) {
    platform.corners.fill(Vector3d::Constant(std::nan("")));
    platform.p_WC = platform.origin = platform.corners[0];
    platform.R_WP.setConstant(std::nan(""));
    if (i >= types_.size()) {
      platform.problem = fmt::format("FORCE_PLATFORM:TYPE has {} values", types_.size());
      return;
    }
    platform.type = static_cast<int>(types_[i]);
    if (platform.type < 1 || platform.type > 7) {
      platform.problem = fmt::format("type {} is not supported; types 1 to 7 are", platform.type);
      return;
    }
    set_corners(platform, i);
    if (platform.usable()) set_channels(platform, i);
    if (platform.usable()) set_origin(platform, i);
    if (platform.usable() && platform.type >= 4) set_calibration(platform, i);
  }

  void set_corners(ForcePlatform& platform, std::size_t i) {
    const C3dParameter* parameter = find_parameter(file_.groups, "FORCE_PLATFORM", "CORNERS");
    // Some writers give corners four numbers.
    const std::size_t stride = parameter && !parameter->dimensions.empty()
                                   ? static_cast<std::size_t>(parameter->dimensions[0])
                                   : 3;
    if (stride < 3 || corners_.size() < 4 * stride * (i + 1)) {
      platform.problem =
          fmt::format("FORCE_PLATFORM:CORNERS has {} values, too few for it", corners_.size());
      return;
    }
    for (std::size_t k = 0; k < 4; ++k) {
      platform.corners[k] = Vector3d::Map(&corners_[stride * (4 * i + k)]) * file_.metres_per_unit;
    }
    const auto& c = platform.corners;
    platform.problem = fault_of_corners(c);
    if (!platform.usable()) return;
    platform.p_WC = (c[0] + c[1] + c[2] + c[3]) / 4.0;
    const Vector3d x = (c[0] + c[3] - c[1] - c[2]).normalized();
    const Vector3d z = x.cross(c[0] + c[1] - c[2] - c[3]).normalized();
    platform.R_WP << x, z.cross(x), z;
  }

  std::string fault_of_corners(const std::array<Vector3d, 4>& c) const {
    std::string at = "FORCE_PLATFORM:CORNERS are no platform's: ";
    for (const Vector3d& corner : c) {
      // Also false for NaN.
      if (!(corner.norm() < kMaxDistance)) return at + "one is far away or no number";
    }
    const std::array<Vector3d, 4> side = {c[0] - c[1], c[1] - c[2], c[3] - c[2], c[0] - c[3]};
    for (const Vector3d& s : side) {
      if (s.norm() > kMinSide && s.norm() < kMaxSide) continue;
      return at +
             fmt::format("a side is {:.4g} {} long", s.norm() / file_.metres_per_unit, file_.unit);
    }
    for (const std::size_t k : {0, 1}) {
      const double a = side[k].norm(), b = side[k + 2].norm();
      if (std::abs(a - b) <= kMaxSideDifference * std::max(a, b)) continue;
      return at + fmt::format("opposite sides are {:.4g} and {:.4g} {} long",
                              a / file_.metres_per_unit, b / file_.metres_per_unit, file_.unit);
    }
    const double cosine = side[0].normalized().dot(side[1].normalized());
    if (std::abs(cosine) > kMaxCosine) {
      return at + fmt::format("sides meet at {:.0f} degrees", std::acos(cosine) * 57.29578);
    }
    return "";
  }

  void set_channels(ForcePlatform& platform, std::size_t i) {
    const std::size_t count = channel_count(platform.type);
    const C3dParameter* parameter = find_parameter(file_.groups, "FORCE_PLATFORM", "CHANNEL");
    const std::vector<double> all = numbers("CHANNEL");
    const std::size_t stride = parameter && parameter->dimensions.size() > 1
                                   ? static_cast<std::size_t>(parameter->dimensions[0])
                                   : count;
    if (stride < count || all.size() < stride * (i + 1)) {
      platform.problem = fmt::format("FORCE_PLATFORM:CHANNEL does not name its {} channels", count);
      return;
    }
    for (std::size_t k = 0; k < count; ++k) {
      const double channel = all[stride * i + k];
      if (!(channel >= 1.0 && channel <= file_.analog.channel_count())) {
        platform.problem = fmt::format("FORCE_PLATFORM:CHANNEL names channel {}; the file has {}",
                                       channel, file_.analog.channel_count());
        return;
      }
      platform.channels.push_back(static_cast<int>(channel) - 1);
      platform.to_si.push_back(si_factor(platform, k));
    }
  }

  // Channels of types 4 to 7 are volts, or what their calibration matrix makes newtons of. Where
  // the unit says nothing, lengths are in the unit of points.
  double si_factor(const ForcePlatform& platform, std::size_t k) const {
    const std::string& unit =
        file_.analog.units[static_cast<std::size_t>(platform.channels.back())];
    const bool moment = platform.type != 3 && k >= 3;
    if (platform.type >= 4) return 1.0;
    if (platform.type == 1 && k < 5 && moment) {  // a position
      return c3d::metres_per(unit).value_or(file_.metres_per_unit);
    }
    return newtons_per(unit, moment).value_or(moment ? file_.metres_per_unit : 1.0);
  }

  // The surface lies above the transducers and z points down; many files have the vector from the
  // surface instead, as older certificates of makers have it.
  void set_origin(ForcePlatform& platform, std::size_t i) {
    if (platform.type == 1) {
      platform.origin.setZero();
      return;
    }
    if (origins_.size() < 3 * (i + 1) || !Vector3d::Map(&origins_[3 * i]).allFinite()) {
      platform.problem = "FORCE_PLATFORM:ORIGIN does not give its three numbers";
      return;
    }
    platform.origin = Vector3d::Map(&origins_[3 * i]) * file_.metres_per_unit;
    if (has_four_transducers(platform.type)) {
      platform.origin.z() = -std::abs(platform.origin.z());
      if (platform.origin.x() != 0.0 && platform.origin.y() != 0.0) return;
      platform.has_moments = false;
      warn(platform,
           "FORCE_PLATFORM:ORIGIN lacks the distances of its transducers; there are no "
           "moments and no centre of pressure");
    } else if (platform.origin.z() > 0.0) {
      platform.origin = -platform.origin;
      warn(platform, "FORCE_PLATFORM:ORIGIN lies above its surface; the sign was changed");
    }
  }

  // Columns first: dimensions are row, column, platform.
  void set_calibration(ForcePlatform& platform, std::size_t i) {
    const std::vector<double> all = numbers("CAL_MATRIX");
    const C3dParameter* parameter = find_parameter(file_.groups, "FORCE_PLATFORM", "CAL_MATRIX");
    const std::size_t columns = channel_count(platform.type);
    const std::size_t rows = has_four_transducers(platform.type) ? columns : 6;
    const bool fits = parameter && parameter->dimensions.size() >= 2 &&
                      static_cast<std::size_t>(parameter->dimensions[0]) == rows &&
                      static_cast<std::size_t>(parameter->dimensions[1]) == columns;
    const auto r = static_cast<Eigen::Index>(rows), c = static_cast<Eigen::Index>(columns);
    if (all.empty() && rows == columns) {
      warn(platform,
           "FORCE_PLATFORM:CAL_MATRIX is missing; its channels were taken as forces and "
           "moments");
      platform.calibration = Eigen::MatrixXd::Identity(r, c);
    } else if (!fits || all.size() < rows * columns * (i + 1)) {
      platform.problem = fmt::format("FORCE_PLATFORM:CAL_MATRIX has {} values, not {} × {} for it",
                                     all.size(), rows, columns);
      return;
    } else {
      platform.calibration = Eigen::MatrixXd::Map(&all[rows * columns * i], r, c);
    }
    if (rows == 6) platform.calibration.bottomRows(3) *= file_.metres_per_unit;
    if (!platform.calibration.allFinite()) {
      platform.problem = "FORCE_PLATFORM:CAL_MATRIX holds what is no number";
    }
  }

  const C3dFile& file_;
  std::vector<Warning>& warnings_;
  const std::vector<double> corners_, origins_, types_;
};

}  // namespace

std::vector<ForcePlatform> find_force_platforms(const C3dFile& file,
                                                std::vector<Warning>& warnings) {
  return Finder(file, warnings).find();
}

}  // namespace sinew
