#include "ik/tracking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>

#include "ik/cold_start.h"
#include "ik/warm_start.h"
#include "tests/ik/methods.h"
#include "tests/ik/walker.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// A walker and what cameras saw of it.
struct Recording {
  Walker walker;
  MarkerFile file;
  RowMatrix truth;  // frames × coordinates

  TrackingProblem bind(const IkTaskSet* tasks = nullptr, const RowMatrix* values = nullptr) const {
    return bind_recording(walker.model, walker.tree, file, tasks, values);
  }
  TrackingResult track(const TrackingProblem& problem, const TrackingOptions& options) const {
    return sinew::track(walker.model, walker.tree, problem, file.markers, options);
  }
  int column(int marker, int axis = 0) const { return 3 * marker + axis; }
};

// Every coordinate swings at a frequency of its own, 100 frames a second.
double swing(int coordinate, double time) {
  return 0.3 * std::sin(2.0 * (1.0 + 0.1 * coordinate) * time + coordinate);
}

Recording record(int frames, Walker walker = Walker()) {
  Recording r{std::move(walker), {}, {}};
  const KinematicTree& tree = r.walker.tree;
  MarkerTrajectories& markers = r.file.markers;
  r.file.path = "walk.trc";
  markers.rate = 100.0;
  for (const Marker& m : r.walker.model.markers) markers.names.push_back(m.name);
  markers.time = Eigen::VectorXd::LinSpaced(frames, 0.0, (frames - 1) / 100.0);
  markers.p_WM.resize(frames, 3 * markers.marker_count());
  r.truth.resize(frames, static_cast<Eigen::Index>(r.walker.model.coordinates.size()));
  KinematicWorkspace ws(tree);
  for (int frame = 0; frame < frames; ++frame) {
    markers.frame_numbers.push_back(frame + 1);
    for (std::size_t c = 0; c < tree.q_of_coordinate.size(); ++c) {
      const int v = tree.v_of_coordinate[c];
      if (tree.unknown_of_v[static_cast<std::size_t>(v)] < 0) continue;
      if (static_cast<int>(c) == r.walker.unseen) continue;
      ws.q[static_cast<std::size_t>(tree.q_of_coordinate[c])] =
          swing(static_cast<int>(c), markers.time[frame]);
    }
    update_poses(tree, ws);
    for (std::size_t c = 0; c < tree.q_of_coordinate.size(); ++c) {
      r.truth(frame, static_cast<Eigen::Index>(c)) =
          ws.q[static_cast<std::size_t>(tree.q_of_coordinate[c])];
    }
    for (int m = 0; m < markers.marker_count(); ++m) {
      const Marker& marker = r.walker.model.markers[static_cast<std::size_t>(m)];
      markers.p_WM.row(frame).segment<3>(3 * m) =
          (ws.X_WB[static_cast<std::size_t>(marker.body)] * marker.p_BM).transpose();
    }
  }
  return r;
}

void shake(Recording& r, double size) {
  std::mt19937 random(1);
  std::normal_distribution<double> value(0.0, size);
  for (Eigen::Index i = 0; i < r.file.markers.p_WM.size(); ++i) {
    r.file.markers.p_WM.data()[i] += value(random);
  }
}

void hide(Recording& r, int frame, int marker) {
  r.file.markers.p_WM.row(frame).segment<3>(3 * marker).setConstant(kNaN);
}

TrackingOptions one_thread() {
  TrackingOptions options;
  options.threads = 1;
  return options;
}

bool same_bytes(const RowMatrix& a, const RowMatrix& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

std::vector<std::string> texts(const std::vector<Warning>& warnings) {
  std::vector<std::string> result;
  for (const Warning& w : warnings) result.push_back(to_string(w));
  return result;
}

class TrackingBy : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Tracking, TrackingBy, testing::ValuesIn(kEveryMethod), test_name_of);

TEST_P(TrackingBy, RecoversTheMotion) {
  const Recording r = record(20);
  TrackingOptions options = one_thread();
  options.minimizer.method = GetParam();
  options.minimizer.gradient_tolerance = 1e-11;
  options.minimizer.max_iterations = 100000;
  const TrackingResult result = r.track(r.bind(), options);
  EXPECT_LE((result.coordinates - r.truth).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_FALSE(result.stopped);
  for (const FrameResult& frame : result.frames) {
    EXPECT_TRUE(converged(frame.termination));
    EXPECT_LE(frame.marker_rms, frame.marker_max);
    EXPECT_LE(frame.marker_max, 1e-7);
    EXPECT_EQ(frame.measured_markers, r.file.markers.marker_count());
  }
}

TEST(Tracking, StartsEveryFrameFromTheOnesBefore) {
  const Recording r = record(30);
  const TrackingProblem problem = r.bind();
  TrackingOptions options = one_thread();
  const TrackingResult result = r.track(problem, options);
  EXPECT_EQ(result.time, r.file.markers.time);
  // The same frames by hand.
  Minimizer minimizer(r.walker.tree, problem.problem, options.minimizer);
  ColdStart cold_start(r.walker.tree, problem.problem, options.minimizer, options.cold_start);
  IkTargets targets(problem.problem);
  std::vector<double> q = r.walker.tree.default_q;
  WarmStart warm_start(r.walker.tree, problem.problem);
  for (int frame = 0; frame < 30; ++frame) {
    set_targets(problem, r.file.markers, frame, targets);
    if (frame > 0) warm_start.advance(r.walker.tree, problem.problem, targets, q);
    const Summary& summary =
        frame > 0 ? minimizer.minimize(targets, q) : cold_start.minimize(targets, q);
    const FrameResult& found = result.frames[static_cast<std::size_t>(frame)];
    EXPECT_EQ(found.iterations, summary.iterations);
    EXPECT_EQ(found.evaluations, summary.evaluations);
    EXPECT_EQ(found.cost, summary.final_cost);
    for (std::size_t c = 0; c < r.walker.tree.q_of_coordinate.size(); ++c) {
      EXPECT_EQ(result.coordinates(frame, static_cast<Eigen::Index>(c)),
                q[static_cast<std::size_t>(r.walker.tree.q_of_coordinate[c])]);
    }
  }
}

TEST(Tracking, GivesTheSameBytesWithAnyNumberOfThreads) {
  Recording r = record(300);  // five pieces
  shake(r, 0.003);
  const TrackingProblem problem = r.bind();
  const TrackingResult one = r.track(problem, one_thread());
  for (const int threads : {2, 7, 0}) {
    TrackingOptions options;
    options.threads = threads;
    const TrackingResult many = r.track(problem, options);
    EXPECT_TRUE(same_bytes(one.coordinates, many.coordinates)) << threads;
    EXPECT_TRUE(same_bytes(one.marker_errors, many.marker_errors)) << threads;
    for (std::size_t i = 0; i < one.frames.size(); ++i) {
      EXPECT_EQ(one.frames[i].termination, many.frames[i].termination);
      EXPECT_EQ(one.frames[i].iterations, many.frames[i].iterations);
      EXPECT_EQ(one.frames[i].evaluations, many.frames[i].evaluations);
      EXPECT_EQ(one.frames[i].cost, many.frames[i].cost);
      EXPECT_EQ(one.frames[i].worst_marker, many.frames[i].worst_marker);
    }
  }
}

TEST(Tracking, FindsTheSameMotionInPiecesAsInOne) {
  Recording r = record(200);
  shake(r, 0.003);
  const TrackingProblem problem = r.bind();
  const TrackingResult whole = r.track(problem, one_thread());
  TrackingOptions options = one_thread();
  for (const int begin : {0, 63, 64, 65, 199}) {
    options.first_frame = begin;
    options.end_frame = 200;
    const TrackingResult part = r.track(problem, options);
    ASSERT_EQ(part.coordinates.rows(), 200 - begin);
    EXPECT_EQ(part.time[0], r.file.markers.time[begin]);
    // Other starts end elsewhere within the gradient's tolerance: 1e-9 · 36 over curvatures of
    // 0.005 and more.
    EXPECT_LE((part.coordinates - whole.coordinates.bottomRows(200 - begin)).cwiseAbs().maxCoeff(),
              1e-5);
  }
}

// A body on a bent rail, x = q³ − 3q and y = q/5: from q = −2 a target at q = 2, where x is the
// same as at −1, leads no further than −1.
Walker rail() {
  Walker walker;
  walker.model = empty_model();
  add_body(walker.model, 0, Joint::Kind::kCustom, "t");
  std::array<TransformAxis, 6>& axes = walker.model.joints[0].axes;
  for (std::size_t i = 0; i < 6; ++i) axes[i].axis = Vector3d::Unit(static_cast<int>(i % 3));
  axes[3].coordinate = axes[4].coordinate = 0;
  axes[3].function = {PolynomialFunction{{1.0, 0.0, -3.0, 0.0}}};
  axes[4].function = {LinearFunction{0.2, 0.0}};
  walker.model.coordinates[0].default_value = -2.0;
  Marker& marker = walker.model.markers.emplace_back();
  marker.name = "m1";
  marker.body = 1;
  walker.compile();
  return walker;
}

TEST(Tracking, ContinuesAPieceFromWhereTheOneBeforeEndsIfThatIsBetter) {
  Recording r{rail(), {}, {}};
  r.file.markers.names = {"m1"};
  r.file.markers.time = Eigen::VectorXd::LinSpaced(130, 0.0, 1.29);
  r.file.markers.p_WM.resize(130, 3);
  r.truth.resize(130, 1);
  for (int frame = 0; frame < 130; ++frame) {  // there within the first piece
    const double q = std::min(2.0, -2.0 + 4.0 * frame / 60.0);
    r.truth(frame, 0) = q;
    r.file.markers.p_WM.row(frame) << q * q * q - 3.0 * q, 0.2 * q, 0.0;
  }
  const TrackingProblem problem = r.bind();
  IkTargets targets(problem.problem);
  set_targets(problem, r.file.markers, 64, targets);
  std::vector<double> q = {-2.0};
  EXPECT_GE(Minimizer(r.walker.tree, problem.problem, {}).minimize(targets, q).final_cost, 0.1);
  for (const int threads : {1, 2}) {
    TrackingOptions options;
    options.threads = threads;
    const TrackingResult result = r.track(problem, options);
    EXPECT_LE((result.coordinates - r.truth).cwiseAbs().maxCoeff(), 1e-6);
  }
}

TEST(Tracking, RejectsFramesThatTheRecordingDoesNotHave) {
  const Recording r = record(10);
  const TrackingProblem problem = r.bind();
  const auto error_of = [&](int first, int end) -> std::string {
    TrackingOptions options = one_thread();
    options.first_frame = first;
    options.end_frame = end;
    try {
      r.track(problem, options);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(error_of(0, 11), "frames 0 to 11 are not in a recording of 10 frames");
  EXPECT_EQ(error_of(-1, 5), "frames -1 to 5 are not in a recording of 10 frames");
  EXPECT_EQ(error_of(6, 5), "frames 6 to 5 are not in a recording of 10 frames");
  EXPECT_EQ(error_of(5, 5), "no error");
}

TEST(TrackingOptions, AreRejectedByFieldValueAndBound) {
  TrackingOptions options;
  options.threads = -1;
  try {
    options.validate();
    ADD_FAILURE() << "was taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "TrackingOptions.threads is -1; expected 0 or more");
  }
  options = {};
  options.minimizer.max_iterations = 0;
  EXPECT_THROW(options.validate(), std::invalid_argument);
}

TEST(Tracking, LeavesOutMarkersWhereTheyAreNotMeasured) {
  Recording r = record(20);
  shake(r, 0.002);
  hide(r, 4, 3);
  hide(r, 4, 7);
  const TrackingResult with_gaps = r.track(r.bind(), one_thread());
  const FrameResult& gap = with_gaps.frames[4];
  EXPECT_EQ(gap.measured_markers, r.file.markers.marker_count() - 2);
  EXPECT_TRUE(std::isnan(with_gaps.marker_errors(4, 3)));
  EXPECT_TRUE(std::isnan(with_gaps.marker_errors(4, 7)));
  // The statistics are of what was measured.
  double sum = 0.0, worst = 0.0;
  for (int m = 0; m < r.file.markers.marker_count(); ++m) {
    const double error = with_gaps.marker_errors(4, m);
    if (std::isnan(error)) continue;
    sum += error * error;
    worst = std::max(worst, error);
  }
  EXPECT_DOUBLE_EQ(gap.marker_rms, std::sqrt(sum / gap.measured_markers));
  EXPECT_EQ(gap.marker_max, worst);
  EXPECT_EQ(with_gaps.marker_errors(4, gap.worst_marker), worst);
  EXPECT_DOUBLE_EQ(gap.cost, 0.5 * sum);
  // Where a hidden marker is does not matter.
  Recording elsewhere = r;
  for (int m = 0; m < r.file.markers.marker_count(); ++m) {
    if (m != 3 && m != 7) continue;
    elsewhere.file.markers.p_WM.row(4).segment<3>(3 * m).setConstant(kNaN);
  }
  EXPECT_TRUE(same_bytes(elsewhere.track(elsewhere.bind(), one_thread()).coordinates,
                         with_gaps.coordinates));
}

TEST(Tracking, StaysWhereAFrameHasNoMarkers) {
  Recording r = record(10);
  for (int m = 0; m < r.file.markers.marker_count(); ++m) hide(r, 6, m);
  const TrackingResult result = r.track(r.bind(), one_thread());
  EXPECT_EQ(result.coordinates.row(6), result.coordinates.row(5));
  EXPECT_EQ(result.frames[6].measured_markers, 0);
  EXPECT_TRUE(std::isnan(result.frames[6].marker_rms));
  EXPECT_TRUE(std::isnan(result.frames[6].marker_max));
  EXPECT_EQ(result.frames[6].worst_marker, -1);
  EXPECT_EQ(result.frames[6].cost, 0.0);
  EXPECT_LE((result.coordinates.row(7) - r.truth.row(7)).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(Tracking, KeepsLockedCoordinatesAndFollowsPrescribedOnes) {
  Walker walker;
  const int arm = 9;  // turns the upper arm
  walker.model.coordinates[arm].prescribed = ScalarFunction{LinearFunction{2.0, 0.1}};
  walker.compile();
  Recording r = record(20);
  r.walker = walker;
  const TrackingResult result = r.track(r.bind(), one_thread());
  for (int frame = 0; frame < 20; ++frame) {
    EXPECT_EQ(result.coordinates(frame, walker.locked), 0.2);
    EXPECT_DOUBLE_EQ(result.coordinates(frame, arm), 2.0 * r.file.markers.time[frame] + 0.1);
  }
}

TEST(Tracking, StopsWhenProgressSaysSo) {
  const Recording r = record(200);
  const TrackingProblem problem = r.bind();
  for (const int threads : {1, 2}) {
    TrackingOptions options;
    options.threads = threads;
    std::atomic<int> calls = 0;
    options.progress = [&](int done, int total) {
      EXPECT_LE(done, total);
      EXPECT_EQ(total, 200);
      ++calls;
      return done < 32;
    };
    const TrackingResult result = r.track(problem, options);
    EXPECT_TRUE(result.stopped);
    EXPECT_GE(calls, 2);
    EXPECT_LE(calls, 32 + threads);  // two, unless a frame takes long
    EXPECT_EQ(result.frames.back().termination, Termination::kNone);
  }
}

TEST(Tracking, ReportsProgressToTheLastFrame) {
  const Recording r = record(70);
  TrackingOptions options = one_thread();
  std::vector<int> done_frames;
  options.progress = [&](int done, int) {
    done_frames.push_back(done);
    return true;
  };
  EXPECT_FALSE(r.track(r.bind(), options).stopped);
  // Every 16 frames, and oftener where they take long.
  int before = 0;
  for (const int done : done_frames) {
    EXPECT_GT(done, before);
    EXPECT_LE(done, before + 16);
    before = done;
  }
  EXPECT_EQ(before, 70);
}

TEST(EvaluateCoordinates, MeasuresAsTrackingDoes) {
  Recording r = record(20);
  shake(r, 0.002);
  hide(r, 3, 2);
  const TrackingProblem problem = r.bind();
  TrackingOptions options = one_thread();
  options.first_frame = 2;
  const TrackingResult tracked = r.track(problem, options);
  const TrackingResult measured = evaluate_coordinates(r.walker.model, r.walker.tree, problem,
                                                       r.file.markers, 2, tracked.coordinates);
  for (std::size_t i = 0; i < tracked.frames.size(); ++i) {
    EXPECT_EQ(measured.frames[i].cost, tracked.frames[i].cost);
    EXPECT_EQ(measured.frames[i].marker_rms, tracked.frames[i].marker_rms);
    EXPECT_EQ(measured.frames[i].worst_marker, tracked.frames[i].worst_marker);
    EXPECT_EQ(measured.frames[i].measured_markers, tracked.frames[i].measured_markers);
  }
  EXPECT_TRUE(same_bytes(measured.marker_errors, tracked.marker_errors));
  EXPECT_EQ(measured.time, tracked.time);
}

TEST(UndeterminedCoordinates, AreThoseThatNoMarkerSees) {
  const Recording r = record(1);
  const TrackingProblem problem = r.bind();
  IkTargets targets(problem.problem);
  set_targets(problem, r.file.markers, 0, targets);
  std::vector<double> q = r.walker.tree.default_q;
  EXPECT_EQ(undetermined_coordinates(r.walker.model, r.walker.tree, problem, targets, q),
            std::vector<int>{r.walker.unseen});
}

TEST(UndeterminedCoordinates, IncludeWhatDependsOnThem) {
  Recording r = record(1);
  for (int m = 0; m < r.file.markers.marker_count(); ++m) {  // shank, patella and beyond
    if (r.walker.model.markers[static_cast<std::size_t>(m)].body >= 6) hide(r, 0, m);
  }
  const TrackingProblem problem =
      bind_recording(r.walker.model, r.walker.tree, record(1).file, nullptr, nullptr);
  IkTargets targets(problem.problem);
  set_targets(problem, r.file.markers, 0, targets);
  const std::vector<int> found = undetermined_coordinates(r.walker.model, r.walker.tree, problem,
                                                          targets, r.walker.tree.default_q);
  const int knee = r.walker.coordinate_of(6), ankle = r.walker.coordinate_of(8);
  EXPECT_EQ(found, (std::vector<int>{knee, r.walker.dependent, ankle, r.walker.unseen}));
}

IkTask marker_task(const std::string& name, double weight) {
  IkTask task;
  task.name = name;
  task.weight = weight;
  return task;
}

IkTask coordinate_task(const std::string& name, IkTask::ValueType type, double value, int line) {
  IkTask task;
  task.kind = IkTask::Kind::kCoordinate;
  task.name = name;
  task.value_type = type;
  task.value = value;
  task.line = line;
  return task;
}

// A task of weight 1 for every marker.
IkTaskSet all_markers(const Recording& r) {
  IkTaskSet tasks;
  tasks.path = "tasks.xml";
  for (const std::string& name : r.file.markers.names) tasks.tasks.push_back(marker_task(name, 1));
  return tasks;
}

TEST(BindRecording, TracksEveryCommonMarkerWithoutTasks) {
  const Recording r = record(1);
  const TrackingProblem problem = r.bind();
  ASSERT_EQ(problem.markers.size(), r.walker.model.markers.size());
  for (std::size_t i = 0; i < problem.markers.size(); ++i) {
    EXPECT_EQ(problem.markers[i].name, r.file.markers.names[i]);
    EXPECT_EQ(problem.markers[i].weight, 1.0);
    EXPECT_EQ(problem.problem.positions[i].weight, Eigen::Matrix3d::Identity());
  }
  EXPECT_TRUE(problem.warnings.empty());
  EXPECT_TRUE(problem.coordinates.empty());
}

TEST(BindRecording, WarnsOfMarkersThatAreNotUsed) {
  Recording r = record(2);
  r.file.markers.names[0] = "RASIS";
  hide(r, 0, 5);
  hide(r, 1, 5);
  EXPECT_EQ(texts(r.bind().warnings),
            (std::vector<std::string>{
                "walk.trc: 1 recorded markers are not in the model and are not used: RASIS",
                "walk.trc: 1 markers of the model are not in the recording: m1",
                "walk.trc: 1 markers are never measured: m6"}));
  EXPECT_EQ(r.bind().markers.size(), r.walker.model.markers.size() - 2);
}

TEST(BindRecording, ListsEightMarkersAndCountsTheRest) {
  Recording r = record(1);
  for (int i = 0; i < 11; ++i) r.file.markers.names[static_cast<std::size_t>(i)] += "_x";
  const std::vector<std::string> found = texts(r.bind().warnings);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(
      found[0],
      "walk.trc: 11 recorded markers are not in the model and are not used: m1_x, m2_x, m3_x, "
      "m4_x, m5_x, m6_x, m7_x, m8_x and 3 more");
}

TEST(BindRecording, TracksOnlyWhatTasksName) {
  const Recording r = record(1);
  IkTaskSet tasks;
  tasks.path = "tasks.xml";
  tasks.tasks = {marker_task("m2", 3.0), marker_task("m4", 0.0), marker_task("nose", 1.0),
                 marker_task("m2", 5.0), marker_task("m7", 1.0)};
  tasks.tasks[2].line = 12;
  tasks.tasks[3].line = 15;
  tasks.tasks[4].apply = false;
  const TrackingProblem problem = r.bind(&tasks);
  ASSERT_EQ(problem.markers.size(), 1u);
  EXPECT_EQ(problem.markers[0].name, "m2");
  EXPECT_EQ(problem.problem.positions[0].weight, 3.0 * Eigen::Matrix3d::Identity());
  const std::vector<std::string> found = texts(problem.warnings);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0], "tasks.xml:12: marker 'nose' of a task is not in the model");
  EXPECT_EQ(found[1], "tasks.xml:15: marker 'm2' has a second task; the first one counts");
  EXPECT_EQ(
      found[2].find("walk.trc: 34 recorded markers have no task and are not used: m1, m3, m5"), 0u)
      << found[2];
}

std::string error_of(const Recording& r, const IkTaskSet* tasks, const RowMatrix* values) {
  try {
    r.bind(tasks, values);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(BindRecording, RejectsARecordingWithoutAMarkerOfTheModel) {
  Recording r = record(1);
  for (std::string& name : r.file.markers.names) name = "lab:" + name;
  const std::string error = error_of(r, nullptr, nullptr);
  EXPECT_EQ(error.find("walk.trc: no marker is left to track"), 0u) << error;
  EXPECT_NE(error.find("names that model 'small' has too (m1, m2, m3, m4, m5, m6, m7, m8 and 28 "
                       "more)"),
            std::string::npos)
      << error;
  EXPECT_NE(error.find("lab:m1, lab:m2"), std::string::npos) << error;
  EXPECT_NE(error.find("Rename markers, or add them to the model or to the tasks."),
            std::string::npos)
      << error;
}

TEST(BindRecording, PullsCoordinatesToDefaultGivenAndFileValues) {
  Recording r = record(3);
  r.walker.model.coordinates[9].default_value = 0.25;
  r.walker.compile();
  RowMatrix values = RowMatrix::Constant(3, r.truth.cols(), kNaN);
  values.col(11) << 0.1, 0.2, 0.3;
  IkTaskSet tasks = all_markers(r);
  using enum IkTask::ValueType;
  tasks.tasks.push_back(coordinate_task("q9", kDefault, 7.0, 1));
  tasks.tasks.push_back(coordinate_task("q10", kManual, -0.5, 2));
  tasks.tasks.push_back(coordinate_task("q11", kFromFile, 7.0, 3));
  tasks.tasks.back().weight = 4.0;
  const TrackingProblem problem = r.bind(&tasks, &values);
  ASSERT_EQ(problem.coordinates.size(), 3u);
  IkTargets targets(problem.problem);
  for (int frame = 0; frame < 3; ++frame) {
    set_targets(problem, r.file.markers, frame, targets);
    EXPECT_EQ(targets.coordinates, (std::vector<double>{0.25, -0.5, values(frame, 11)}));
  }
  // Beside the mean of the markers: times the sum of their weights.
  EXPECT_EQ(problem.problem.coordinates[2].weight,
            4.0 * static_cast<double>(r.walker.model.markers.size()));
  EXPECT_EQ(problem.problem.coordinates[2].q, r.walker.tree.q_of_coordinate[11]);
}

TEST(BindRecording, MovesAnUnseenCoordinateToItsTasksValue) {
  const Recording r = record(3);
  IkTaskSet tasks = all_markers(r);
  const std::string name =
      r.walker.model.coordinates[static_cast<std::size_t>(r.walker.unseen)].name;
  tasks.tasks.push_back(coordinate_task(name, IkTask::ValueType::kManual, -0.4, 9));
  const TrackingResult result = r.track(r.bind(&tasks), one_thread());
  // max|g| < 1e-9 · (36 + 1) with a weight of 1.
  for (int frame = 0; frame < 3; ++frame) {
    EXPECT_NEAR(result.coordinates(frame, r.walker.unseen), -0.4, 4e-8);
  }
}

TEST(BindRecording, RejectsATaskWithoutItsFile) {
  const Recording r = record(1);
  IkTaskSet tasks = all_markers(r);
  tasks.tasks.push_back(coordinate_task("q9", IkTask::ValueType::kFromFile, 0.0, 77));
  const std::string error = error_of(r, &tasks, nullptr);
  EXPECT_EQ(error.find("tasks.xml:77: coordinate 'q9' takes its values from a file"), 0u) << error;
  EXPECT_NE(error.find("Name one as <coordinate_file>, or set <value_type>."), std::string::npos)
      << error;
  const RowMatrix without = RowMatrix::Constant(1, r.truth.cols(), kNaN);
  EXPECT_EQ(error_of(r, &tasks, &without), error);
}

TEST(BindRecording, WarnsOfCoordinateTasksWithoutEffect) {
  const Recording r = record(1);
  IkTaskSet tasks = all_markers(r);
  using enum IkTask::ValueType;
  const std::string locked =
      r.walker.model.coordinates[static_cast<std::size_t>(r.walker.locked)].name;
  tasks.tasks.push_back(coordinate_task("elbow", kManual, 0.0, 40));
  tasks.tasks.push_back(coordinate_task(locked, kManual, 0.0, 41));
  const TrackingProblem problem = r.bind(&tasks);
  EXPECT_TRUE(problem.coordinates.empty());
  EXPECT_EQ(
      texts(problem.warnings),
      (std::vector<std::string>{"tasks.xml:40: coordinate 'elbow' of a task is not in the model",
                                "tasks.xml:41: coordinate '" + locked +
                                    "' of a task is locked in the model: it stays at 0.2"}));
}

TEST(BindRecording, KeepsCutLoopsTogether) {
  Walker walker;
  // The foot's tip is pinned to the ground where the default pose has it, 0.02 m aside.
  PointConstraint& pin = walker.model.point_constraints.emplace_back();
  pin.name = "pin";
  pin.body1 = 0;
  pin.body2 = 8;
  KinematicWorkspace ws(walker.tree);
  update_poses(walker.tree, ws);
  pin.p_B1P1 = ws.X_WB[8].p + Vector3d(0.02, 0, 0);
  Recording r = record(5, walker);
  const TrackingProblem problem = r.bind();
  ASSERT_EQ(problem.problem.coincidences.size(), 1u);
  EXPECT_EQ(problem.problem.coincidences[0].weight, 1e6);
  const TrackingResult result = r.track(problem, one_thread());
  for (int frame = 0; frame < 5; ++frame) {
    EXPECT_TRUE(converged(result.frames[static_cast<std::size_t>(frame)].termination));
    for (std::size_t c = 0; c < walker.tree.q_of_coordinate.size(); ++c) {
      ws.q[static_cast<std::size_t>(walker.tree.q_of_coordinate[c])] =
          result.coordinates(frame, static_cast<Eigen::Index>(c));
    }
    update_poses(walker.tree, ws);
    // A thousandth of the markers' errors, as BindingOptions promises.
    EXPECT_LE((ws.X_WB[8].p - pin.p_B1P1).norm(),
              1e-3 * result.frames[static_cast<std::size_t>(frame)].marker_max);
  }
}

TEST(BindRecording, TurnsWeldsIntoCoincidenceAndAlignment) {
  Walker walker;
  WeldConstraint& weld = walker.model.welds.emplace_back();
  weld.name = "weld";
  weld.body1 = 4;
  weld.body2 = 8;
  weld.X_B1F1.p = {0.1, 0, 0};
  weld.X_B2F2.R = rotation_from_body_xyz({0.1, 0.2, 0.3});
  const Recording r = record(1, walker);
  const IkProblem problem = r.bind().problem;
  ASSERT_EQ(problem.coincidences.size(), 1u);
  ASSERT_EQ(problem.alignments.size(), 1u);
  EXPECT_EQ(problem.coincidences[0].p_AP, weld.X_B1F1.p);
  EXPECT_EQ(problem.alignments[0].R_BG, weld.X_B2F2.R);
  EXPECT_EQ(problem.alignments[0].weight, 1e6);
}

}  // namespace
}  // namespace sinew
