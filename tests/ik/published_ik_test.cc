// Our inverse kinematics against published ones, by the same code at the same frames.

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "tests/ik/methods.h"
#include "tests/ik/published_trials.h"

namespace sinew {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
// Rounding of two sums of the same squares.
constexpr double kCostRounding = 1e-9;
// Where markers can be met exactly the gradient's tolerance, 1e-9 · 64 markers, decides: less than
// a thousandth of what cameras resolve.
constexpr double kExactMiss = 1e-6;  // [m]

double rms(const Eigen::VectorXd& v) {
  return std::sqrt(v.squaredNorm() / static_cast<double>(v.size()));
}

double aggregate_marker_rms(const TrackingResult& result) {
  double sum = 0.0;
  int count = 0;
  for (const FrameResult& frame : result.frames) {
    sum += frame.measured_markers * frame.marker_rms * frame.marker_rms;
    count += frame.measured_markers;
  }
  return std::sqrt(sum / count);
}

class PublishedIk : public testing::TestWithParam<PublishedFiles> {
 protected:
  void SetUp() override {
    if (!is_present(GetParam())) {
      GTEST_SKIP() << "no recordings: " << kPublishedData / GetParam().model << " is missing";
    }
    trial_ = read_published(GetParam());
  }

  TrackingResult solve(Method method, double gradient_tolerance) const {
    TrackingOptions options = trial_.options();
    options.minimizer.method = method;
    options.minimizer.gradient_tolerance = gradient_tolerance;
    return track(trial_.model, trial_.tree, trial_.tracking, trial_.recording.markers, options);
  }

  TrackingResult published() const {
    return evaluate_coordinates(trial_.model, trial_.tree, trial_.tracking,
                                trial_.recording.markers, trial_.first_frame, trial_.coordinates);
  }

  // At the first frame's solution, per coordinate.
  std::vector<bool> undetermined(const TrackingResult& ours) const {
    std::vector<double> q = trial_.tree.default_q;
    for (std::size_t c = 0; c < trial_.tree.q_of_coordinate.size(); ++c) {
      q[static_cast<std::size_t>(trial_.tree.q_of_coordinate[c])] =
          ours.coordinates(0, static_cast<Eigen::Index>(c));
    }
    IkTargets targets(trial_.tracking.problem);
    set_targets(trial_.tracking, trial_.recording.markers, trial_.first_frame, targets);
    std::vector<bool> result(trial_.model.coordinates.size(), false);
    for (const int c :
         undetermined_coordinates(trial_.model, trial_.tree, trial_.tracking, targets, q)) {
      result[static_cast<std::size_t>(c)] = true;
    }
    return result;
  }

  bool is_angle(std::size_t c) const {
    return trial_.model.coordinates[c].motion == Coordinate::Motion::kRotational;
  }

  // What the published values imply for coordinates that the file leaves out: dependent ones follow
  // their couplers.
  RowMatrix implied_coordinates() const {
    RowMatrix result = trial_.coordinates;
    KinematicWorkspace ws(trial_.tree);
    for (Eigen::Index frame = 0; frame < result.rows(); ++frame) {
      for (std::size_t c = 0; c < trial_.tree.q_of_coordinate.size(); ++c) {
        ws.q[static_cast<std::size_t>(trial_.tree.q_of_coordinate[c])] =
            trial_.coordinates(frame, static_cast<Eigen::Index>(c));
      }
      update_poses(trial_.tree, ws);
      for (std::size_t c = 0; c < trial_.tree.q_of_coordinate.size(); ++c) {
        result(frame, static_cast<Eigen::Index>(c)) =
            ws.q[static_cast<std::size_t>(trial_.tree.q_of_coordinate[c])];
      }
    }
    return result;
  }

  void print_undetermined(const std::vector<bool>& undetermined) const {
    std::cout << trial_.name << ": undetermined:";
    for (std::size_t c = 0; c < undetermined.size(); ++c) {
      if (undetermined[c]) std::cout << ' ' << trial_.model.coordinates[c].name;
    }
    std::cout << (std::count(undetermined.begin(), undetermined.end(), true) == 0 ? " none\n"
                                                                                  : "\n");
  }

  PublishedTrial trial_;
};

TEST_P(PublishedIk, CostsNoMoreAtEveryFrame) {
  const TrackingResult theirs = published();
  for (const Method method : {Method::kGaussNewton, Method::kLbfgs}) {
    const TrackingResult ours = solve(method, 1e-9);
    double worst = -1.0;
    for (std::size_t i = 0; i < ours.frames.size(); ++i) {
      EXPECT_TRUE(converged(ours.frames[i].termination));
      if (GetParam().exact_markers) {
        EXPECT_LE(ours.frames[i].marker_max, kExactMiss) << "frame " << i;
        EXPECT_LE(theirs.frames[i].marker_max, 1e-13) << "frame " << i;
      } else {
        EXPECT_LE(ours.frames[i].cost, theirs.frames[i].cost * (1.0 + kCostRounding))
            << "frame " << i;
        worst = std::max(worst, ours.frames[i].cost / theirs.frames[i].cost - 1.0);
      }
    }
    const double our_rms = aggregate_marker_rms(ours), their_rms = aggregate_marker_rms(theirs);
    std::cout << trial_.name << " by " << to_string(method) << ": worst cost excess " << worst
              << ", marker rms " << 1e3 * our_rms << " mm, published " << 1e3 * their_rms
              << " mm\n";
  }
}

// Counts frames whose plain rms is larger than the published one's. Where weights differ that is no
// defect: what is minimized is weighted, and lower at every one of these frames.
void print_plain_rms(const std::string& name, const TrackingResult& ours,
                     const TrackingResult& theirs) {
  int larger = 0;
  double worst = 0.0;
  for (std::size_t i = 0; i < ours.frames.size(); ++i) {
    const double excess = ours.frames[i].marker_rms - theirs.frames[i].marker_rms;
    larger += excess > 0.0;
    worst = std::max(worst, excess);
  }
  std::cout << name << ": unweighted rms larger at " << larger << " of " << ours.frames.size()
            << " frames, by " << 1e6 * worst << " um at most\n";
}

TEST_P(PublishedIk, HasNoWorseMarkersOnTheWhole) {
  const TrackingResult ours = solve(Method::kGaussNewton, 1e-9), theirs = published();
  if (GetParam().exact_markers) {
    EXPECT_LE(aggregate_marker_rms(ours), kExactMiss);
    return;
  }
  print_plain_rms(trial_.name, ours, theirs);
  double our_sum = 0.0, their_sum = 0.0, weights = 0.0;
  for (std::size_t i = 0; i < ours.frames.size(); ++i) {
    for (std::size_t m = 0; m < trial_.tracking.markers.size(); ++m) {
      const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(m);
      const double weight = trial_.tracking.markers[m].weight;
      if (std::isnan(ours.marker_errors(row, column))) continue;
      our_sum += weight * ours.marker_errors(row, column) * ours.marker_errors(row, column);
      their_sum += weight * theirs.marker_errors(row, column) * theirs.marker_errors(row, column);
      weights += weight;
    }
  }
  EXPECT_LE(std::sqrt(our_sum / weights), std::sqrt(their_sum / weights) * (1.0 + kCostRounding));
}

TEST_P(PublishedIk, HasTheAnglesThatMarkersDetermine) {
  const TrackingResult ours = solve(Method::kGaussNewton, 1e-9);
  const std::vector<bool> free = undetermined(ours);
  print_undetermined(free);
  const RowMatrix expected = implied_coordinates();
  double worst = 0.0;
  std::string worst_name;
  for (std::size_t c = 0; c < free.size(); ++c) {
    if (free[c]) continue;
    const Eigen::VectorXd difference = ours.coordinates.col(static_cast<Eigen::Index>(c)) -
                                       expected.col(static_cast<Eigen::Index>(c));
    const std::string& name = trial_.model.coordinates[c].name;
    if (GetParam().exact_markers) {
      EXPECT_LE(difference.cwiseAbs().maxCoeff(), is_angle(c) ? 0.01 * kDegree : 1e-5) << name;
    } else {
      EXPECT_LE(rms(difference), is_angle(c) ? 0.2 * kDegree : 1e-4) << name;
    }
    if (is_angle(c) && rms(difference) > worst) {
      worst = rms(difference);
      worst_name = name;
    }
  }
  std::cout << trial_.name << ": largest rms difference of an angle: " << worst / kDegree
            << " deg, " << worst_name << "\n";
}

TEST_P(PublishedIk, HasConverged) {
  const TrackingResult usual = solve(Method::kGaussNewton, 1e-9);
  const TrackingResult tight = solve(Method::kGaussNewton, 1e-11);
  const std::vector<bool> free = undetermined(usual);
  double worst = 0.0;
  for (std::size_t c = 0; c < free.size(); ++c) {
    if (free[c]) continue;
    const auto column = static_cast<Eigen::Index>(c);
    const double shift =
        (usual.coordinates.col(column) - tight.coordinates.col(column)).cwiseAbs().maxCoeff();
    EXPECT_LE(shift, is_angle(c) ? 0.01 * kDegree : 1e-5) << trial_.model.coordinates[c].name;
    if (is_angle(c)) worst = std::max(worst, shift);
  }
  std::cout << trial_.name << ": a hundredfold tighter tolerance moves angles by at most "
            << worst / kDegree << " deg\n";
}

std::string name_of(const testing::TestParamInfo<PublishedFiles>& info) {
  std::string name;
  for (const char c : info.param.name) {
    if (std::isalnum(static_cast<unsigned char>(c))) name += c;
  }
  return name;
}

INSTANTIATE_TEST_SUITE_P(Rows, PublishedIk, testing::ValuesIn(published_files()), name_of);

}  // namespace
}  // namespace sinew
