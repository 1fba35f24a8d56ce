#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "data/tool_setup.h"
#include "data/trc_file.h"
#include "ik/assembler.h"
#include "ik/filled_weights.h"
#include "ik/marker_placement.h"
#include "ik/tracking.h"
#include "model/osim_file.h"
#include "tests/ik/small_model.h"

/// Coordinate tasks mean what they mean to OpenSim:
///
///     min Σ w_m |Δp_m|² / Σ w_m + Σ w_c Δq_c², over the markers m seen in the frame.
namespace sinew {
namespace {

using Eigen::Vector3d;

constexpr double kTarget = 0.1;  // of the task [rad]
constexpr double kTaskWeight = 0.03;

// A pin at the world's origin with three markers in its plane, seen where other angles have them.
struct Pin {
  MusculoskeletalModel model = empty_model();
  KinematicTree tree;
  MarkerFile recording;
  std::vector<double> weights{1.0, 2.0, 0.5};
  std::vector<Vector3d> places{{0.3, 0.1, 0}, {-0.1, 0.4, 0}, {0.2, -0.5, 0}};
  std::vector<double> angles{0.5, 0.8, 0.3};

  explicit Pin(int frames = 1) {
    const int body = add_body(model, 0, Joint::Kind::kPin, "r");
    MarkerTrajectories& markers = recording.markers;
    recording.path = "pin.trc";
    markers.rate = 100.0;
    markers.time = Eigen::VectorXd::LinSpaced(frames, 0.0, 0.01 * (frames - 1));
    markers.p_WM.resize(frames, 9);
    for (int f = 0; f < frames; ++f) markers.frame_numbers.push_back(f + 1);
    for (std::size_t m = 0; m < 3; ++m) {
      Marker& marker = model.markers.emplace_back();
      marker.name = "m" + std::to_string(m);
      marker.body = body;
      marker.p_BM = places[m];
      markers.names.push_back(marker.name);
      for (int f = 0; f < frames; ++f) {
        markers.p_WM.row(f).segment<3>(3 * static_cast<Eigen::Index>(m)) = seen(m).transpose();
      }
    }
    validate(model);
    tree = compile_tree(model);
  }

  Vector3d seen(std::size_t m) const {
    return Eigen::AngleAxisd(angles[m], Vector3d::UnitZ()) * places[m];
  }

  void hide(int frame, int marker) {
    recording.markers.p_WM.row(frame).segment<3>(3 * marker).setConstant(kNaN);
  }

  IkTaskSet tasks(double factor = 1.0) const {
    IkTaskSet set;
    set.path = "tasks.xml";
    for (std::size_t m = 0; m < 3; ++m) {
      set.tasks.push_back({.name = "m" + std::to_string(m), .weight = factor * weights[m]});
    }
    set.tasks.push_back({.kind = IkTask::Kind::kCoordinate,
                         .name = "q0",
                         .weight = kTaskWeight,
                         .value_type = IkTask::ValueType::kManual,
                         .value = kTarget});
    return set;
  }

  TrackingProblem bind(const IkTaskSet& set, const BindingOptions& options = {}) const {
    return bind_recording(model, tree, recording, &set, nullptr, options);
  }

  Eigen::VectorXd solve(const TrackingProblem& problem) const {
    TrackingOptions options;
    options.threads = 1;
    options.minimizer.gradient_tolerance = 1e-12;
    return track(model, tree, problem, recording.markers, options).coordinates.col(0);
  }

  // The root of the derivative by the angle, Σ w_m |p_m|² sin(q − angle_m) + W w_c (q − target),
  // by bisection; `scales` are those of the markers' weights, W what the task is multiplied by.
  double root(const std::vector<double>& scales, double W) const {
    const auto slope = [&](double q) {
      double sum = W * kTaskWeight * (q - kTarget);
      for (std::size_t m = 0; m < 3; ++m) {
        sum += scales[m] * weights[m] * places[m].squaredNorm() * std::sin(q - angles[m]);
      }
      return sum;
    };
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (slope(middle) > 0.0 ? high : low) = middle;
    }
    return low;
  }
};

TEST(CoordinateTasks, StandBesideTheMeanOfTheMarkers) {
  const Pin pin;
  const double expected = pin.root({1, 1, 1}, 3.5);
  EXPECT_NEAR(pin.solve(pin.bind(pin.tasks()))[0], expected, 1e-10);
  // So the scale of the markers' weights does not count.
  EXPECT_NEAR(pin.solve(pin.bind(pin.tasks(10.0)))[0], expected, 1e-10);
}

TEST(CoordinateTasks, OfOurOwnStandBesideTheSum) {
  const Pin pin;
  BindingOptions options;
  options.task_scale = BindingOptions::TaskScale::kMarkerSum;
  EXPECT_NEAR(pin.solve(pin.bind(pin.tasks(), options))[0], pin.root({1, 1, 1}, 1.0), 1e-10);
}

TEST(CoordinateTasks, CountTheMarkersThatAreSeen) {
  Pin pin(4);
  pin.hide(1, 1);
  pin.hide(2, 0);
  pin.hide(2, 2);
  for (int m = 0; m < 3; ++m) pin.hide(3, m);
  const Eigen::VectorXd q = pin.solve(pin.bind(pin.tasks()));
  EXPECT_NEAR(q[0], pin.root({1, 1, 1}, 3.5), 1e-10);
  EXPECT_NEAR(q[1], pin.root({1, 0, 1}, 1.5), 1e-10);
  EXPECT_NEAR(q[2], pin.root({0, 1, 0}, 2.0), 1e-10);
  EXPECT_NEAR(q[3], kTarget, 1e-10);  // nothing else is left
}

TEST(CoordinateTasks, CountFilledSamplesByTheirScale) {
  Pin pin(3);
  pin.hide(2, 1);
  const MarkerTrajectories& markers = pin.recording.markers;
  TrackingProblem problem = pin.bind(pin.tasks());
  weigh_filled_samples(problem, markers, {{"m1", 0, 1}}, 0.25);
  EXPECT_NEAR(pin.solve(problem)[0], pin.root({1, 0.25, 1}, 2.0), 1e-10);
  // A sample that weighs nothing is as one that is missing.
  weigh_filled_samples(problem, markers, {{"m1", 1, 1}}, 0.0);
  const Eigen::VectorXd q = pin.solve(problem);
  EXPECT_NEAR(q[1], q[2], 1e-12);
}

TEST(CoordinateTasks, MeanTheSameToTheAssembler) {
  Pin pin(6);
  pin.hide(2, 1);
  pin.hide(3, 0);
  pin.hide(3, 2);
  const TrackingProblem problem = pin.bind(pin.tasks());
  AssemblerSolver assembler(pin.model, problem, 1e-10);
  IkTargets targets(problem.problem);
  std::vector<double> q{0.0};
  const Eigen::VectorXd ours = pin.solve(problem);
  for (int frame = 0; frame < 6; ++frame) {
    set_targets(problem, pin.recording.markers, frame, targets);
    ASSERT_TRUE(assembler.solve(targets, 0.01 * frame, q).succeeded);
    EXPECT_NEAR(q[0], ours[frame], 1e-6);
  }
}

TEST(CoordinateTasks, PlaceMarkersLikewise) {
  const Pin pin;
  const IkTaskSet tasks = pin.tasks();
  const MarkerPlacementResult placed = place_markers(pin.model, pin.recording, &tasks, nullptr);
  EXPECT_NEAR(placed.coordinates[0], pin.root({1, 1, 1}, 3.5), 1e-8);
}

// A heavy task does not leave the markers far from their minimum.
TEST(CoordinateTasks, OfAnyWeightLeaveTheOthersToTheMarkers) {
  Pin pin;
  add_body(pin.model, 0, Joint::Kind::kPin, "r");
  pin.tree = compile_tree(pin.model);
  IkTaskSet tasks = pin.tasks();
  tasks.tasks.back().name = "q1";
  tasks.tasks.back().weight = 1e6;
  TrackingOptions options;
  options.threads = 1;
  const TrackingResult result =
      track(pin.model, pin.tree, pin.bind(tasks), pin.recording.markers, options);
  EXPECT_TRUE(converged(result.frames[0].termination));
  EXPECT_NEAR(result.coordinates(0, 0), pin.root({1, 1, 1}, 0.0), 1e-6);
  EXPECT_NEAR(result.coordinates(0, 1), kTarget, 1e-9);
}

// tests/golden/README.md says where the numbers come from.
class OpenSimTasks : public testing::Test {
 protected:
  const std::filesystem::path folder_ = "../shared/data/opensim-models/Gait2354_Simbody";

  void SetUp() override {
    if (!std::filesystem::exists(folder_)) GTEST_SKIP() << folder_ << " is missing";
    std::ifstream file("tests/golden/osim_coordinate_tasks.json");
    golden_ = nlohmann::json::parse(file);
    model_ = read_osim(folder_ / "subject01_simbody.osim");
    tree_ = compile_tree(model_);
  }

  // The frames that the case is of.
  MarkerFile recording_of(const nlohmann::json& a_case) const {
    MarkerFile file = read_trc(folder_ / "subject01_walk1.trc");
    MarkerTrajectories& markers = file.markers;
    const int first = golden_["first"], count = golden_["frames"];
    markers.time = Eigen::VectorXd(markers.time.segment(first, count));
    markers.p_WM = RowMatrix(markers.p_WM.middleRows(first, count));
    markers.frame_numbers.erase(markers.frame_numbers.begin(),
                                markers.frame_numbers.begin() + first);
    markers.frame_numbers.resize(static_cast<std::size_t>(count));
    for (const auto& [name, frames] : a_case["hidden"].items()) {
      const int m = markers.find_marker(name);
      for (const int frame : frames) {
        markers.p_WM.row(frame).segment<3>(3 * m).setConstant(kNaN);
      }
    }
    return file;
  }

  static IkTaskSet tasks_of(const nlohmann::json& a_case) {
    IkTaskSet set;
    for (const auto& each : a_case["tasks"]) {
      IkTask task;
      if (each[0] == "coordinate") task.kind = IkTask::Kind::kCoordinate;
      task.name = each[1];
      task.weight = each[2];
      if (each[3] == "manual_value") task.value_type = IkTask::ValueType::kManual;
      if (each[3] == "from_file") task.value_type = IkTask::ValueType::kFromFile;
      task.value = each[4];
      set.tasks.push_back(task);
    }
    return set;
  }

  // Of the case's file of coordinates.
  RowMatrix values() const {
    const int frames = golden_["frames"];
    RowMatrix values =
        RowMatrix::Constant(frames, static_cast<Eigen::Index>(model_.coordinates.size()), kNaN);
    for (int i = 0; i < frames; ++i) {
      values(i, model_.find_coordinate("hip_flexion_l")) = 0.2 + 0.1 * i;
    }
    return values;
  }

  nlohmann::json golden_;
  MusculoskeletalModel model_;
  KinematicTree tree_;
};

TEST_F(OpenSimTasks, PullAsFarAsInOpenSim) {
  for (const nlohmann::json& a_case : golden_["cases"]) {
    SCOPED_TRACE(a_case["name"]);
    const MarkerFile recording = recording_of(a_case);
    const IkTaskSet tasks = tasks_of(a_case);
    const RowMatrix from_file = values();
    const TrackingProblem problem = bind_recording(model_, tree_, recording, &tasks, &from_file);
    TrackingOptions options;
    options.threads = 1;
    const RowMatrix q = track(model_, tree_, problem, recording.markers, options).coordinates;
    double worst = 0.0;
    for (const auto& [name, column] : a_case["coordinates"].items()) {
      const int c = model_.find_coordinate(name);
      ASSERT_GE(c, 0) << name;
      const bool turns =
          model_.coordinates[static_cast<std::size_t>(c)].motion == Coordinate::Motion::kRotational;
      for (Eigen::Index f = 0; f < q.rows(); ++f) {
        const double theirs = column[static_cast<std::size_t>(f)];
        const double ours = q(f, c) * (turns ? 180.0 / std::numbers::pi : 1.0);
        worst = std::max(worst, std::abs(ours - theirs));
        EXPECT_NEAR(ours, theirs, 1e-4) << name << " in frame " << f;
      }
    }
    RecordProperty(a_case["name"], std::to_string(worst));
  }
}

}  // namespace
}  // namespace sinew
