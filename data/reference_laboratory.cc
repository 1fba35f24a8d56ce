#include "data/reference_laboratory.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "data/laboratory_axes.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// The laboratory W and the platforms P, turned against the walk's axes M.
const Eigen::Matrix3d kR_WM = (Eigen::Matrix3d() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished();
const Eigen::Matrix3d kR_WP = (Eigen::Matrix3d() << 0, 1, 0, 1, 0, 0, 0, 0, -1).finished();

// The common platform of 20 by 18 1/4 inches, and a typical certificate's place of its transducers'
// origin O: from there to the surface's centre C, in P [m].
constexpr double kLength = 0.508, kWidth = 0.464;
const Vector3d kP_OC(0.0002, -0.0004, -0.038);

constexpr int kColumns = 9;   // of a foot: force, point, torque
constexpr int kChannels = 6;  // of a platform

Vector3d middle_of_footprint(const WalkFoot& foot) {
  const double heading = foot.side == "l" ? foot.toe_out : -foot.toe_out;
  const Eigen::AngleAxisd R_MB(heading, Vector3d::UnitY());
  Eigen::AlignedBox3d box;
  for (const Vector3d& p_BO : foot.outline) box.extend(Vector3d(foot.p_WB + R_MB * p_BO));
  const Vector3d center = box.center();
  return {center.x(), 0.0, center.z()};
}

void set_screen(C3dFile& file) {
  file.screen = C3dScreen{Vector3d::UnitY(), Vector3d::UnitZ()};
  set_parameter(file.groups, "POINT", C3dParameter::of_text("X_SCREEN", "+Y"));
  set_parameter(file.groups, "POINT", C3dParameter::of_text("Y_SCREEN", "+Z"));
}

void add_events(const ReferenceWalk& walk, const std::vector<ReferenceStep>& steps, double duration,
                C3dFile& file) {
  for (const ReferenceStep& step : steps) {
    const bool left = walk.feet[static_cast<std::size_t>(step.foot)].side == "l";
    const auto add = [&](double time, const char* label) {
      if (time < 0.0 || time > duration) return;
      C3dEvent event;
      event.time = time;
      event.label = label;
      event.context = left ? "Left" : "Right";
      file.events.push_back(event);
    };
    add(step.strike, "Foot Strike");
    add(step.toe_off, "Foot Off");
  }
  std::stable_sort(file.events.begin(), file.events.end(),
                   [](const C3dEvent& a, const C3dEvent& b) { return a.time < b.time; });
}

void add_platforms(const std::vector<ReferenceStep>& steps, C3dFile& file) {
  const auto count = static_cast<int>(steps.size());
  std::vector<float> corners, origins;
  std::vector<std::int16_t> channels;
  const auto append = [&file](const Vector3d& p, std::vector<float>& values) {
    for (const double x : p) values.push_back(static_cast<float>(x / file.metres_per_unit));
  };
  for (const ReferenceStep& step : steps) {
    for (const auto& [x, y] : {std::pair{1, 1}, {-1, 1}, {-1, -1}, {1, -1}}) {
      const Vector3d p_CK(0.5 * kLength * x, 0.5 * kWidth * y, 0.0);
      append(kR_WM * step.p_MC + kR_WP * p_CK, corners);
    }
    append(kP_OC, origins);
    for (int k = 0; k < kChannels; ++k) {
      channels.push_back(static_cast<std::int16_t>(channels.size() + 1));
    }
  }
  const auto set = [&file](C3dParameter parameter) {
    set_parameter(file.groups, "FORCE_PLATFORM", std::move(parameter));
  };
  set(C3dParameter::of_integers("USED", {}, {static_cast<std::int16_t>(count)}));
  set(C3dParameter::of_integers("TYPE", {count}, std::vector<std::int16_t>(steps.size(), 2)));
  set(C3dParameter::of_integers("ZERO", {2}, {0, 0}));  // the channels have no offset
  set(C3dParameter::of_reals("CORNERS", {3, 4, count}, std::move(corners)));
  set(C3dParameter::of_reals("ORIGIN", {3, count}, std::move(origins)));
  set(C3dParameter::of_integers("CHANNEL", {kChannels, count}, std::move(channels)));
}

// Names, units and places for samples; all of them zero.
void add_channels(Eigen::Index samples, std::size_t platforms, C3dAnalog& analog) {
  for (std::size_t i = 1; i <= platforms; ++i) {
    for (const char* name : {"Fx", "Fy", "Fz", "Mx", "My", "Mz"}) {
      analog.labels.push_back(name + std::to_string(i));
      analog.units.push_back(*name == 'F' ? "N" : "Nmm");
    }
  }
  analog.values.setZero(samples, static_cast<Eigen::Index>(analog.labels.size()));
}

// What the platform under `step` measures at row `i` [N, N mm].
void measure(const ReferenceStep& step, const TimeTable& forces, Eigen::Index i,
             Eigen::Ref<Eigen::RowVectorXd> channels) {
  const auto load = forces.values.row(i).segment<kColumns>(kColumns * step.foot);
  const Vector3d force = kR_WM * load.segment<3>(0).transpose();
  const Vector3d p_WQ = kR_WM * load.segment<3>(3).transpose();
  const Vector3d torque = kR_WM * load.segment<3>(6).transpose();
  const Vector3d p_WO = kR_WM * step.p_MC - kR_WP * kP_OC;
  const Vector3d moment = (p_WQ - p_WO).cross(force) + torque;
  channels << (kR_WP.transpose() * force).transpose(),
      (kR_WP.transpose() * moment).transpose() * 1e3;
}

}  // namespace

std::vector<ReferenceStep> steps_of(const ReferenceWalk& walk, double duration) {
  std::vector<ReferenceStep> steps;
  for (std::size_t f = 0; f < walk.feet.size(); ++f) {
    const WalkFoot& foot = walk.feet[f];
    const Vector3d first = middle_of_footprint(foot);
    // The first stride whose stance has not ended at 0 s.
    double stride = std::floor(-foot.strike - foot.stance) + 1.0;
    for (; (foot.strike + stride) * walk.stride_time <= duration; stride += 1.0) {
      const double strike = (foot.strike + stride) * walk.stride_time;
      steps.push_back({static_cast<int>(f), strike, strike + foot.stance * walk.stride_time,
                       first + stride * walk.stride_length * Vector3d::UnitX()});
    }
  }
  std::stable_sort(steps.begin(), steps.end(), [](const ReferenceStep& a, const ReferenceStep& b) {
    return a.strike < b.strike;
  });
  return steps;
}

C3dFile reference_laboratory(const MarkerTrajectories& markers) {
  C3dFile file;
  file.markers = markers;
  rotate_vectors(kR_WM, file.markers.p_WM);
  set_screen(file);
  return file;
}

C3dFile reference_laboratory(const ReferenceWalk& walk, const MarkerTrajectories& markers,
                             const TimeTable& forces) {
  const double duration = markers.time[markers.time.size() - 1];
  const double step =
      forces.time.size() > 1 ? forces.time[1] - forces.time[0] : std::numeric_limits<double>::max();
  const double ratio = std::round(1.0 / (markers.rate * step));
  const auto samples = static_cast<Eigen::Index>(ratio) * markers.frame_count();
  const double rate = ratio * markers.rate;
  // A thousandth of a sample is more than rounding.
  if (!(ratio >= 1.0) || forces.time.size() < samples ||
      std::abs(forces.time[samples - 1] - static_cast<double>(samples - 1) / rate) > 1e-3 / rate) {
    throw std::invalid_argument(
        fmt::format("reference_laboratory got forces at {} times; they must cover {} frames at a "
                    "whole multiple "
                    "of {} Hz",
                    forces.time.size(), markers.frame_count(), markers.rate));
  }
  const std::vector<ReferenceStep> steps = steps_of(walk, duration);
  if (steps.size() > kMaxPlatforms) {
    throw std::invalid_argument(
        fmt::format("reference_laboratory got a walk of {} steps; it must have at most {}",
                    steps.size(), kMaxPlatforms));
  }

  C3dFile file = reference_laboratory(markers);
  add_events(walk, steps, duration, file);
  add_platforms(steps, file);
  file.analog.rate = rate;
  file.analog.samples_per_frame = static_cast<int>(ratio);
  add_channels(samples, steps.size(), file.analog);
  for (std::size_t s = 0; s < steps.size(); ++s) {
    for (Eigen::Index i = 0; i < samples; ++i) {
      const double time = forces.time[i];
      if (time < steps[s].strike || time > steps[s].toe_off) continue;
      const Eigen::Index first = kChannels * static_cast<Eigen::Index>(s);
      measure(steps[s], forces, i, file.analog.values.row(i).segment<kChannels>(first));
    }
  }
  return file;
}

}  // namespace sinew
