#include "dynamics/marker_artifacts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

namespace sinew {
namespace {

using Eigen::Vector3d;

constexpr double kGap = 0.1;          // of an occluded marker [s]
constexpr double kMislabelled = 0.2;  // how long two names are exchanged [s]

// Streams of random numbers of their own, so that one artifact does not change another.
enum Stream : std::uint64_t { kNoise = 0, kGaps = 1, kNames = 2, kSkin = 3 };

std::mt19937_64 random_stream(const MarkerArtifacts& artifacts, Stream stream,
                              std::uint64_t index = 0) {
  std::seed_seq seed{artifacts.seed & 0xffffffffu, artifacts.seed >> 32,
                     static_cast<std::uint64_t>(stream), index};
  return std::mt19937_64(seed);
}

// Box & Muller's normal deviate from two uniform ones: the same on every platform, which
// std::normal_distribution is not.
double normal_deviate(std::mt19937_64& random) {
  const auto uniform = [&] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53; };
  const double radius = std::sqrt(-2.0 * std::log(uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

// Relative to the shank's.
double softness(const std::string& bone) {
  if (bone.starts_with("femur")) return 2.0;
  return bone.starts_with("tibia") ? 1.0 : 0.5;
}

void add_noise(const MarkerArtifacts& artifacts, MarkerTrajectories& markers) {
  std::mt19937_64 random = random_stream(artifacts, kNoise);
  for (double& x : markers.p_WM.reshaped()) x += artifacts.noise * normal_deviate(random);
}

void exchange_names(const MarkerArtifacts& artifacts, MarkerTrajectories& markers) {
  const auto count = static_cast<std::uint64_t>(markers.marker_count());
  const auto frames = static_cast<std::uint64_t>(markers.frame_count());
  if (count < 2) return;
  const auto length = std::min<std::uint64_t>(
      frames, std::max<std::uint64_t>(
                  1, static_cast<std::uint64_t>(std::llround(kMislabelled * markers.rate))));
  std::mt19937_64 random = random_stream(artifacts, kNames);
  for (int i = 0; i < artifacts.mislabels; ++i) {
    const auto a = static_cast<Eigen::Index>(random() % count);
    const auto b = static_cast<Eigen::Index>(
        (static_cast<std::uint64_t>(a) + 1 + random() % (count - 1)) % count);
    const auto first = static_cast<Eigen::Index>(random() % (frames - length + 1));
    const auto rows = static_cast<Eigen::Index>(length);
    markers.p_WM.block(first, 3 * a, rows, 3).swap(markers.p_WM.block(first, 3 * b, rows, 3));
  }
}

void make_gaps(const MarkerArtifacts& artifacts, MarkerTrajectories& markers) {
  std::mt19937_64 random = random_stream(artifacts, kGaps);
  const auto frames = static_cast<std::uint64_t>(markers.frame_count());
  const auto gap =
      static_cast<std::uint64_t>(std::max<long long>(1, std::llround(kGap * markers.rate)));
  const double to_lose = std::floor(artifacts.occlusion * static_cast<double>(frames));
  for (int m = 0; m < markers.marker_count(); ++m) {
    auto p_WM = markers.p_WM.middleCols<3>(3 * m);
    for (double lost = 0.0; lost < to_lose;) {
      const auto first = random() % frames;
      for (auto i = first; i < std::min(frames, first + gap) && lost < to_lose; ++i) {
        const auto frame = static_cast<Eigen::Index>(i);
        if (std::isnan(p_WM(frame, 0))) continue;
        p_WM.row(frame).setConstant(kNaN);
        lost += 1.0;
      }
    }
  }
}

}  // namespace

void MarkerArtifacts::validate() const {
  const auto require = [](bool good, const char* field, double value, const char* bound) {
    if (good) return;
    throw std::invalid_argument(
        fmt::format("MarkerArtifacts::{} is {}; it must be {}", field, value, bound));
  };
  require(noise >= 0.0 && std::isfinite(noise), "noise", noise, "0 or more metres");
  require(soft_tissue >= 0.0 && std::isfinite(soft_tissue), "soft_tissue", soft_tissue,
          "0 or more metres");
  require(occlusion >= 0.0 && occlusion < 1.0, "occlusion", occlusion, "from 0 to below 1");
  require(mislabels >= 0, "mislabels", mislabels, "0 or more");
}

Vector3d moved_marker(const MarkerArtifacts& artifacts, const MusculoskeletalModel& model,
                      int marker, double phase) {
  const Marker& m = model.markers[static_cast<std::size_t>(marker)];
  if (artifacts.soft_tissue == 0.0) return m.p_BM;
  std::mt19937_64 random = random_stream(artifacts, kSkin, static_cast<std::uint64_t>(marker));
  Vector3d shift = Vector3d::Zero();
  for (int harmonic = 1; harmonic <= 2; ++harmonic) {
    const double angle = 2.0 * std::numbers::pi * harmonic * phase;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = normal_deviate(random), b = normal_deviate(random);
      shift[axis] += (a * std::cos(angle) + b * std::sin(angle)) / harmonic;
    }
  }
  // Of such a shift the mean square is Σ over harmonics of 3·(1/h)²·(½ + ½)·1.
  const double scale = artifacts.soft_tissue / std::sqrt(3.0 * (1.0 + 0.25));
  return m.p_BM + scale * softness(model.bodies[static_cast<std::size_t>(m.body)].name) * shift;
}

void spoil_markers(const MarkerArtifacts& artifacts, MarkerTrajectories& markers) {
  if (artifacts.noise > 0.0) add_noise(artifacts, markers);
  if (artifacts.mislabels > 0) exchange_names(artifacts, markers);
  if (artifacts.occlusion > 0.0) make_gaps(artifacts, markers);
}

}  // namespace sinew
