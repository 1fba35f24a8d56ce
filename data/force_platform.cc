#include "data/force_platform.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "data/numbers.h"
#include "data/statistics.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// Offsets of amplifiers are tens of newtons; more than that is someone's weight, unless peaks are
// higher by far.
constexpr double kOffsetForce = 50.0;  // [N]
constexpr double kOffsetShare = 0.25;  // of the peak

// Computes the recording of one platform.
class Recorder {
 public:
  Recorder(const C3dFile& file, const ForcePlatform& platform, const ForcePlatformOptions& options,
           std::vector<Warning>& warnings)
      : file_(file), options_(options), warnings_(warnings) {
    recording_.platform = platform;
    recording_.rate = file.analog.rate;
  }

  ForcePlatformRecording record() {
    const bool usable = recording_.platform.usable();
    // Files that name hundreds of platforms would fill the memory with what is not known.
    const Eigen::Index samples = usable ? file_.analog.values.rows() : 0;
    for (RowMatrix* table :
         {&recording_.force, &recording_.moment, &recording_.center, &recording_.free_moment}) {
      table->setConstant(samples, 3, kNaN);
    }
    if (samples == 0) return std::move(recording_);
    collect_channels();
    if (options_.subtract_baseline) subtract_baseline();
    compute_wrenches();
    if (options_.correct) {
      correct_direction();
      correct_moment_unit();
    }
    for (Eigen::Index i = 0; i < samples; ++i) write(i);
    return std::move(recording_);
  }

 private:
  const ForcePlatform& platform() const { return recording_.platform; }
  void warn(const std::string& text) {
    warnings_.push_back(
        {{file_.path, 0}, fmt::format("force platform {}: {}", platform().number, text)});
  }

  void collect_channels() {
    const auto count = static_cast<Eigen::Index>(platform().channels.size());
    channels_.resize(file_.analog.values.rows(), count);
    for (Eigen::Index i = 0; i < count; ++i) {
      channels_.col(i) = file_.analog.values.col(platform().channels[static_cast<std::size_t>(i)]);
    }
  }

  // FORCE_PLATFORM:ZERO counts frames as the file numbers them; 0 stands for 1.
  void subtract_baseline() {
    const std::vector<double> zero = find_numbers(file_.groups, "FORCE_PLATFORM", "ZERO");
    if (zero.size() < 2 || !(zero[1] >= 1.0) || !(zero[0] <= zero[1])) return;
    const auto first_frame = static_cast<double>(file_.layout.first_frame);
    const double from = std::max(zero[0], 1.0) - first_frame;
    const double to = zero[1] + 1.0 - first_frame;
    const Eigen::Index per_frame = file_.layout.analog_ratio;
    const auto limited = [&](double frame) {
      return static_cast<Eigen::Index>(
                 std::clamp(frame, 0.0, static_cast<double>(file_.layout.frames))) *
             per_frame;
    };
    const Eigen::Index begin = limited(from), count = limited(to) - begin;
    if (count <= 0) {
      return warn(
          fmt::format("ZERO names frames {} to {}, which the file does not have; no "
                      "baseline was subtracted",
                      zero[0], zero[1]));
    }
    const Eigen::VectorXd baseline = channels_.middleRows(begin, count).colwise().mean();
    if (!baseline.allFinite()) return;
    if (is_weight(baseline)) {
      return warn(
          fmt::format("it is loaded by {:.0f} N in the frames {} to {} that ZERO names; no "
                      "baseline was subtracted",
                      std::abs(vertical_force(baseline)), zero[0], zero[1]));
    }
    // Positions of type 1 have no offset to lose.
    const Eigen::Index forces = platform().type == 1 ? 3 : channels_.cols();
    channels_.leftCols(forces).rowwise() -= baseline.head(forces).transpose();
  }

  double vertical_force(const Eigen::VectorXd& channels) const {
    return compute_wrench(platform(), channels).force.z();
  }
  // Whether someone stands on the platform in the baseline. An offset may be large, too, if it
  // pushes down and what follows pushes up.
  bool is_weight(const Eigen::VectorXd& baseline) const {
    const double offset = vertical_force(baseline);
    double peak = 0.0;
    for (Eigen::Index i = 0; i < channels_.rows(); ++i) {
      const double force = vertical_force(channels_.row(i).transpose() - baseline);
      if (std::abs(force) > std::abs(peak)) peak = force;
    }
    const bool large = std::abs(offset) > std::max(kOffsetForce, kOffsetShare * std::abs(peak));
    return large && !(offset > 0.0 && peak < 0.0);
  }

  void compute_wrenches() {
    wrenches_.resize(static_cast<std::size_t>(channels_.rows()));
    for (Eigen::Index i = 0; i < channels_.rows(); ++i) {
      wrenches_[static_cast<std::size_t>(i)] =
          compute_wrench(platform(), channels_.row(i).transpose());
    }
  }

  bool is_loaded(const Wrench& wrench) const {
    return std::abs(wrench.force.z()) >= std::max(options_.threshold, 1e-9);
  }

  // Nobody is pulled into the ground: such files hold the force on the platform.
  void correct_direction() {
    const Vector3d up = file_.screen ? file_.screen->y : Vector3d(-platform().R_WP.col(2));
    double impulse = 0.0, peak = 0.0;
    for (const Wrench& wrench : wrenches_) {
      if (!is_loaded(wrench)) continue;
      const double force = up.dot(platform().R_WP * wrench.force);
      impulse += force;
      peak = std::max(peak, std::abs(force));
    }
    if (!(impulse < 0.0) || peak < kOffsetForce) return;
    warn(
        "its forces push the subject down; they were taken as forces on the platform and turned "
        "round");
    for (Wrench& wrench : wrenches_) wrench = {-wrench.force, -wrench.moment};
  }

  // The middle distance of centres of pressure from C, loaded samples only [m].
  double typical_distance() const {
    std::vector<double> distances;
    for (const Wrench& wrench : wrenches_) {
      if (!is_loaded(wrench)) continue;
      const double distance = compute_center(wrench).p_CQ.norm();
      if (std::isfinite(distance)) distances.push_back(distance);
    }
    return median(std::move(distances));
  }

  // N·m under the name of N·mm, or the reverse.
  void correct_moment_unit() {
    if (!platform().has_moments || platform().type == 1) return;
    const double half = 0.5 * (platform().corners[0] - platform().corners[2]).norm();
    const double distance = typical_distance();
    // 50 times nearer than the corner is nobody's step; 50 times farther is on no platform.
    double factor = 1.0;
    if (distance > 50.0 * half && distance < 1000.0 * half) factor = 1e-3;
    if (distance < half / 200.0 && distance > half / 20000.0) factor = 1e3;
    if (factor == 1.0) return;
    warn(
        fmt::format("moments in the units that the file names put the centre of pressure {:.3g} m "
                    "from its middle; moments were multiplied by {:g}",
                    distance, factor));
    for (Wrench& wrench : wrenches_) wrench.moment *= factor;
  }

  void write(Eigen::Index i) {
    const Wrench& wrench = wrenches_[static_cast<std::size_t>(i)];
    const Eigen::Matrix3d& R_WP = platform().R_WP;
    recording_.force.row(i) = R_WP * wrench.force;
    if (!platform().has_moments) return;
    recording_.moment.row(i) = R_WP * wrench.moment;
    if (!is_loaded(wrench)) return;
    const CenterOfPressure center = compute_center(wrench);
    recording_.center.row(i) = platform().p_WC + R_WP * center.p_CQ;
    recording_.free_moment.row(i) = R_WP.col(2) * center.free_moment;
  }

  const C3dFile& file_;
  const ForcePlatformOptions& options_;
  std::vector<Warning>& warnings_;
  ForcePlatformRecording recording_;
  RowMatrix channels_;  // samples × the platform's channels, as stored
  std::vector<Wrench> wrenches_;
};

// fx12, fx34, fy14, fy23, fz1, ..., fz4 of the three forces of each transducer (4).
Eigen::VectorXd pair_up(const Eigen::VectorXd& f) {
  Eigen::VectorXd pairs(8);
  pairs << f[0] + f[3], f[6] + f[9], f[1] + f[10], f[4] + f[7], f[2], f[5], f[8], f[11];
  return pairs;
}

Wrench combine_four_transducers(const ForcePlatform& platform, const Eigen::VectorXd& f) {
  const double a = platform.origin.x(), b = platform.origin.y();
  const Vector3d force(f[0] + f[1], f[2] + f[3], f[4] + f[5] + f[6] + f[7]);
  const Vector3d moment(b * (f[4] + f[5] - f[6] - f[7]), a * (-f[4] + f[5] + f[6] - f[7]),
                        b * (-f[0] + f[1]) + a * (f[2] - f[3]));
  return {force, moment + force.cross(Vector3d(0.0, 0.0, platform.origin.z()))};
}

}  // namespace

void ForcePlatformOptions::validate() const {
  if (threshold >= 0.0 && std::isfinite(threshold)) return;
  throw std::invalid_argument(
      fmt::format("ForcePlatformOptions::threshold is {}; it must be at least 0 N", threshold));
}

Wrench compute_wrench(const ForcePlatform& platform, const Eigen::VectorXd& channels) {
  const auto count = static_cast<Eigen::Index>(platform.to_si.size());
  Eigen::VectorXd f = channels.cwiseProduct(Eigen::VectorXd::Map(platform.to_si.data(), count));
  if (platform.calibration.size() > 0) f = platform.calibration * f;
  if (platform.type == 6) return combine_four_transducers(platform, pair_up(f));
  if (platform.type == 3 || platform.type == 7)
    return combine_four_transducers(platform, f);  // (2)
  const Vector3d force = f.head<3>();
  if (platform.type == 1) {  // (3)
    return {force, Vector3d(f[3], f[4], 0.0).cross(force) + Vector3d(0.0, 0.0, f[5])};
  }
  return {force, f.segment<3>(3) + force.cross(platform.origin)};  // (1)
}

CenterOfPressure compute_center(const Wrench& wrench) {
  const Vector3d& F = wrench.force;
  const Vector3d& M = wrench.moment;
  const double x = -M.y() / F.z(), y = M.x() / F.z();
  return {Vector3d(x, y, 0.0), M.z() - x * F.y() + y * F.x()};
}

ForcePlatforms compute_forces(const C3dFile& file, const ForcePlatformOptions& options) {
  options.validate();
  ForcePlatforms result;
  for (const ForcePlatform& platform : find_force_platforms(file, result.warnings)) {
    result.recordings.push_back(Recorder(file, platform, options, result.warnings).record());
  }
  return result;
}

}  // namespace sinew
