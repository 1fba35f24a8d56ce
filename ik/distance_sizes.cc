#include "ik/distance_sizes.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "data/statistics.h"
#include "ik/box_quadratic.h"
#include "model/kinematic_tree.h"

namespace sinew {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kPoses = 24;
constexpr std::size_t kPairs = 4000;
// Joints turn by this much from their defaults [rad]: what people do while standing or sitting.
constexpr double kTurn = 1.2;
// Pairs that are closer say little of a size, and nothing where markers are misplaced [m].
constexpr double kClose = 0.05;
// Above this spread of the logarithm a distance tells of the pose only.
constexpr double kLoose = 0.35;
// So many pairs across one joint err together by its pose, where weights take them as independent.
constexpr double kTogether = 20.0;

struct Pair {
  int a = -1, b = -1;      // indices of the model's markers
  double measured = kNaN;  // logarithm of the distance
  double generic = 0.0;    // mean of the logarithm over the poses, of the model as it is
  double variance = 0.0;   // about it
};

void add_distances(const MarkerTrajectories& markers, int a, int b, std::vector<double>& all) {
  if (a < 0 || b < 0) return;
  for (int f = 0; f < markers.frame_count(); ++f) {
    const double distance = (markers.position(f, a) - markers.position(f, b)).norm();
    if (std::isfinite(distance)) all.push_back(distance);
  }
}

// Middle distances of all pairs that are measured in the same frames; every so-many-th if there are
// too many.
std::vector<Pair> measured_pairs(const MusculoskeletalModel& model,
                                 const std::vector<FrameSample>& samples,
                                 const std::vector<int>& markers) {
  std::vector<std::vector<int>> columns(samples.size());  // of each marker in each recording
  for (std::size_t s = 0; s < samples.size(); ++s) {
    for (const int m : markers) {
      columns[s].push_back(
          samples[s].file.markers.find_marker(model.markers[static_cast<std::size_t>(m)].name));
    }
  }
  std::vector<Pair> pairs;
  const std::size_t all = markers.size() * (markers.size() - 1) / 2,
                    stride = std::max<std::size_t>(1, (all + kPairs - 1) / kPairs);
  std::size_t index = 0;
  for (std::size_t i = 0; i < markers.size(); ++i) {
    for (std::size_t j = i + 1; j < markers.size(); ++j, ++index) {
      if (index % stride != 0) continue;
      std::vector<double> distances;
      for (std::size_t s = 0; s < samples.size(); ++s) {
        add_distances(samples[s].file.markers, columns[s][i], columns[s][j], distances);
      }
      if (distances.empty()) continue;
      const double middle = median(std::move(distances));
      if (middle > kClose) pairs.push_back({markers[i], markers[j], std::log(middle), 0.0, 0.0});
    }
  }
  return pairs;
}

// Joint angles anywhere within their ranges, but for translations, which stay.
std::vector<std::vector<double>> draw_poses(const MusculoskeletalModel& model,
                                            const KinematicTree& tree) {
  std::mt19937 random(1);
  std::vector<std::vector<double>> poses;
  for (int i = 0; i < kPoses; ++i) {
    std::vector<double> q = tree.default_q;
    for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
      const Coordinate& coordinate = model.coordinates[c];
      // The generator's bits rather than a distribution, which each library draws its own way.
      const double share = static_cast<double>(random()) / 4294967295.0;
      if (coordinate.motion != Coordinate::Motion::kRotational || coordinate.locked) continue;
      double& value = q[static_cast<std::size_t>(tree.q_of_coordinate[c])];
      const double low = std::max(coordinate.range_min, value - kTurn),
                   high = std::min(coordinate.range_max, value + kTurn);
      if (low < high) value = low + share * (high - low);
    }
    poses.push_back(std::move(q));
  }
  return poses;
}

// Logarithms of the pairs' distances in all poses: poses × pairs.
MatrixXd log_distances(const MusculoskeletalModel& model, const std::vector<Pair>& pairs,
                       const std::vector<std::vector<double>>& poses) {
  const KinematicTree tree = compile_tree(model);
  KinematicWorkspace ws(tree);
  MatrixXd logs(static_cast<Eigen::Index>(poses.size()), static_cast<Eigen::Index>(pairs.size()));
  for (std::size_t pose = 0; pose < poses.size(); ++pose) {
    std::copy(poses[pose].begin(), poses[pose].end(), ws.q.begin());
    update_poses(tree, ws);
    const auto position = [&](int m) {
      const Marker& marker = model.markers[static_cast<std::size_t>(m)];
      return (ws.X_WB[static_cast<std::size_t>(marker.body)] * marker.p_BM).eval();
    };
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      // Markers in one place have no size; a millimetre keeps the logarithm finite.
      const double distance = (position(pairs[p].a) - position(pairs[p].b)).norm();
      logs(static_cast<Eigen::Index>(pose), static_cast<Eigen::Index>(p)) =
          std::log(std::max(distance, 1e-3));
    }
  }
  return logs;
}

// Fills in what the model says of each pair, and drops those that tell of the pose only.
std::vector<Pair> telling_pairs(std::vector<Pair> pairs, const MatrixXd& logs,
                                double marker_offset_sd) {
  std::vector<Pair> kept;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    Pair pair = pairs[p];
    const auto column = logs.col(static_cast<Eigen::Index>(p)).array();
    pair.generic = column.mean();
    const double spread = (column - pair.generic).square().mean(),
                 misplaced = marker_offset_sd / std::exp(pair.generic);
    pair.variance = kTogether * spread + 2.0 * misplaced * misplaced;
    if (std::exp(pair.generic) > kClose && spread < kLoose * kLoose) kept.push_back(pair);
  }
  return kept;
}

std::vector<int> landmarks(const MusculoskeletalModel& model, const AutoScaleOptions& options) {
  std::vector<int> markers;
  const auto& technical = options.technical_markers;
  for (int m = 0; m < static_cast<int>(model.markers.size()); ++m) {
    const std::string& name = model.markers[static_cast<std::size_t>(m)].name;
    if (std::find(technical.begin(), technical.end(), name) != technical.end()) continue;
    markers.push_back(m);
  }
  return markers;
}

// ∂(mean logarithm of each pair's distance)/∂(θ's first and the factors): pairs × (1 + factors).
MatrixXd distance_jacobian(const MusculoskeletalModel& model, const AutoScaleParameters& parameters,
                           const std::vector<Pair>& pairs,
                           const std::vector<std::vector<double>>& poses) {
  // By differences: 1e-4 keeps half of the digits, of which two are needed.
  constexpr double kRaise = 1e-4;
  const auto count = static_cast<Eigen::Index>(pairs.size());
  const int k = parameters.factor_count();
  MatrixXd J(count, 1 + k);
  for (int i = 0; i < k; ++i) {
    VectorXd raised = VectorXd::Zero(parameters.count());
    raised[AutoScaleParameters::deviation_of(i)] = kRaise;
    const MatrixXd logs = log_distances(parameters.apply(model, raised), pairs, poses);
    for (Eigen::Index p = 0; p < count; ++p) {
      J(p, 1 + i) = (logs.col(p).mean() - pairs[static_cast<std::size_t>(p)].generic) / kRaise;
    }
  }
  J.col(0) = J.rightCols(k).rowwise().sum();
  return J;
}

}  // namespace

VectorXd sizes_from_distances(const MusculoskeletalModel& model,
                              const AutoScaleParameters& parameters,
                              const std::vector<FrameSample>& samples,
                              const AutoScaleOptions& options) {
  VectorXd theta = VectorXd::Zero(parameters.count());
  const std::vector<int> markers = landmarks(model, options);
  std::vector<Pair> pairs = measured_pairs(model, samples, markers);
  const std::vector<std::vector<double>> poses = draw_poses(model, compile_tree(model));
  pairs = telling_pairs(pairs, log_distances(model, pairs, poses), options.marker_offset_sd);
  if (pairs.empty()) return theta;
  const auto count = static_cast<Eigen::Index>(pairs.size());
  const int k = 1 + parameters.factor_count();
  const MatrixXd J = distance_jacobian(model, parameters, pairs, poses);
  VectorXd y(count), s(count);
  for (Eigen::Index p = 0; p < count; ++p) {
    const Pair& pair = pairs[static_cast<std::size_t>(p)];
    y[p] = pair.measured - pair.generic;
    s[p] = std::sqrt(pair.variance);
  }
  const double independent =
      std::min(1.0, 3.0 * static_cast<double>(markers.size()) / static_cast<double>(count));
  const MatrixXd prior = parameters.prior_precision().topLeftCorner(k, k);
  constexpr int kRounds = 3;      // Huber's weights hardly change after them
  constexpr double kHuber = 1.5;  // standard deviations
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::ArrayXd off = (y - J * theta.head(k)).array().abs() / s.array();
    const VectorXd weight = independent / s.array().square() * (kHuber / off.max(kHuber));
    theta.head(k) = minimize_in_box(J.transpose() * weight.asDiagonal() * J + prior,
                                    -(J.transpose() * (weight.asDiagonal() * y)),
                                    parameters.lower.head(k), parameters.upper.head(k));
  }
  return theta;
}

}  // namespace sinew
