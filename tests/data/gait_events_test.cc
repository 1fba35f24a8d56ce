#include "data/gait_events.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "data/c3d_reader.h"
#include "data/c3d_writer.h"
#include "data/laboratory_axes.h"
#include "tests/data/test_files.h"

namespace sinew {
namespace {

using Kind = GaitEvent::Kind;
using Eigen::Vector3d;

GaitEvent event(Kind kind, Side side, double time) {
  GaitEvent e;
  e.kind = kind;
  e.side = side;
  e.time = time;
  return e;
}

// A force along y that rises and falls on straight lines between times and values.
ForceSignal ramps(const std::vector<std::pair<double, double>>& points) {
  ForceSignal signal;
  signal.name = "platform 1";
  signal.plate = 1;
  signal.rate = 1000.0;
  const auto samples = static_cast<Eigen::Index>(std::lround(points.back().first * 1000.0)) + 1;
  signal.force.setZero(samples, 3);
  signal.center.setZero(samples, 3);
  std::size_t k = 0;
  for (Eigen::Index i = 0; i < samples; ++i) {
    const double t = static_cast<double>(i) / 1000.0;
    while (k + 2 < points.size() && t >= points[k + 1].first) ++k;
    const auto& [t0, f0] = points[k];
    const auto& [t1, f1] = points[k + 1];
    signal.force(i, 1) = f0 + (f1 - f0) * std::clamp((t - t0) / (t1 - t0), 0.0, 1.0);
  }
  return signal;
}

TEST(GaitEvents, ForcesCrossTheirLimitsBetweenSamples) {
  // 20 N at 0.1025 s; 10 N again at 0.6 + 0.2·(700 − 10)/700 s.
  const ForceSignal signal =
      ramps({{0.0, 0.0}, {0.1, 0.0}, {0.1875, 700.0}, {0.6, 700.0}, {0.8, 0.0}, {1.0, 0.0}});
  const auto found = events_from_forces({signal}, nullptr, Vector3d::UnitY());
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].kind, Kind::kHeelStrike);
  EXPECT_NEAR(found[0].time, 0.1025, 1e-9);
  EXPECT_EQ(found[0].by_forces, found[0].time);
  EXPECT_EQ(found[0].plate, 1);
  EXPECT_EQ(found[1].kind, Kind::kToeOff);
  EXPECT_NEAR(found[1].time, 0.6 + 0.2 * 690.0 / 700.0, 1e-9);
}

TEST(GaitEvents, NoiseAboutTheThresholdMakesOneStep) {
  ForceSignal signal =
      ramps({{0.0, 0.0}, {0.2, 0.0}, {0.3, 600.0}, {0.7, 600.0}, {0.8, 0.0}, {1.0, 0.0}});
  // Dips to 12 N after the strike stay above the lower limit.
  for (Eigen::Index i = 204; i < 212; i += 2) signal.force(i, 1) = 12.0;
  EXPECT_EQ(events_from_forces({signal}, nullptr, Vector3d::UnitY()).size(), 2u);
  // What the record cuts has one event; what is no step, none.
  EXPECT_EQ(events_from_forces({ramps({{0.0, 500.0}, {0.3, 500.0}, {0.4, 0.0}, {1.0, 0.0}})},
                               nullptr, Vector3d::UnitY())
                .size(),
            1u);
  EXPECT_TRUE(events_from_forces({ramps({{0.0, 0.0}, {0.3, 30.0}, {0.6, 30.0}, {1.0, 0.0}})},
                                 nullptr, Vector3d::UnitY())
                  .empty());
}

// A left foot whose heel is at x, with a pelvis above; strides of one second.
MarkerTrajectories stepping(double rate) {
  MarkerTrajectories markers;
  markers.names = {"LHEE", "LTOE", "SACR"};
  markers.rate = rate;
  const int frames = static_cast<int>(4.0 * rate) + 1;
  markers.time = Eigen::VectorXd::LinSpaced(frames, 0.0, 4.0);
  markers.p_WM.setZero(frames, 9);
  for (int f = 0; f < frames; ++f) {
    markers.frame_numbers.push_back(f + 1);
    const double t = markers.time[f], pelvis = 1.2 * t;
    // The foot swings about the pelvis as a cosine: foremost at 0.25 s, hindmost at 0.75 s.
    const double foot = pelvis + 0.35 * std::cos(2.0 * M_PI * (t - 0.25));
    markers.p_WM(f, 0) = foot;
    markers.p_WM(f, 3) = foot + 0.2;
    markers.p_WM(f, 6) = pelvis;
    markers.p_WM(f, 7) = 1.0;
  }
  return markers;
}

TEST(GaitEvents, CoordinatesTurnWhereTheyDoInClosedForm) {
  for (const double rate : {50.0, 100.0, 200.0}) {
    const auto found = events_from_kinematics(stepping(rate), Vector3d::UnitY());
    ASSERT_EQ(found.size(), 8u) << rate;
    for (int i = 0; i < 8; ++i) {
      const GaitEvent& e = found[static_cast<std::size_t>(i)];
      EXPECT_EQ(e.kind, i % 2 == 0 ? Kind::kHeelStrike : Kind::kToeOff);
      EXPECT_EQ(e.side, Side::kLeft);
      // The filter has no lag; at the ends it reflects.
      EXPECT_NEAR(e.time, 0.25 + 0.5 * i, 0.002) << rate;
    }
  }
}

TEST(GaitEvents, FileLabelsAreUnderstood) {
  const auto marked = [](double time, const char* label, const char* context) {
    C3dEvent e;
    e.time = time;
    e.label = label;
    e.context = context;
    return e;
  };
  const std::vector<C3dEvent> events = {marked(0.5, "Foot Strike", "Left"),
                                        marked(0.1, "Foot Off", "Right"),
                                        marked(0.7, "RHS", ""),
                                        marked(0.9, "LTO", ""),
                                        marked(1.0, "Event", "General"),
                                        marked(1.1, "Heel Strike", "General")};
  const auto found = events_from_file(events);
  ASSERT_EQ(found.size(), 5u);
  EXPECT_EQ(found[0].kind, Kind::kToeOff);
  EXPECT_EQ(found[0].side, Side::kRight);
  EXPECT_EQ(found[1].side, Side::kLeft);
  EXPECT_EQ(found[2].side, Side::kRight);
  EXPECT_EQ(found[3].kind, Kind::kToeOff);
  EXPECT_EQ(found[3].side, Side::kLeft);
  EXPECT_EQ(found[4].side, Side::kNone);
}

TEST(GaitEvents, SourcesThatTellOfOneEventAreJoined) {
  GaitEvent force = event(Kind::kHeelStrike, Side::kNone, 1.0);
  force.by_forces = 1.0;
  GaitEvent file = event(Kind::kHeelStrike, Side::kLeft, 1.02);
  file.by_file = 1.02;
  GaitEvent kinematic = event(Kind::kHeelStrike, Side::kLeft, 0.97);
  kinematic.by_kinematics = 0.97;
  GaitEvent other = event(Kind::kHeelStrike, Side::kRight, 1.05);
  other.by_kinematics = 1.05;
  const auto merged = merge_events({force}, {file}, {kinematic, other});
  ASSERT_EQ(merged.size(), 2u);
  EXPECT_EQ(merged[0].time, 1.0);
  EXPECT_EQ(merged[0].side, Side::kLeft);
  EXPECT_EQ(merged[0].by_file, 1.02);
  EXPECT_EQ(merged[0].by_kinematics, 0.97);
  EXPECT_EQ(merged[1].side, Side::kRight);
}

TEST(GaitEvents, ComeBackFromAC3dFile) {
  C3dFile file;
  file.markers = stepping(100.0);
  file.events = c3d_events(events_from_kinematics(file.markers, Vector3d::UnitY()));
  const TemporaryFolder folder;
  write_c3d(folder.path() / "events.c3d", file);
  const auto back = events_from_file(read_c3d(folder.path() / "events.c3d").events);
  ASSERT_EQ(back.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(back[i].side, Side::kLeft);
    EXPECT_NEAR(back[i].time, file.events[i].time, 1e-6);
  }
}

// Differences of the nearest events of the same kind and side [s].
std::vector<double> differences(const std::vector<GaitEvent>& a, const std::vector<GaitEvent>& b) {
  std::vector<double> result;
  for (const GaitEvent& x : a) {
    double best = 1e9;
    for (const GaitEvent& y : b) {
      const bool same = x.kind == y.kind && x.side == y.side;
      if (same && std::abs(y.time - x.time) < std::abs(best)) best = y.time - x.time;
    }
    if (std::abs(best) < 0.3) result.push_back(best);
  }
  return result;
}

struct Published {
  const char* file;
  std::size_t by_forces;  // events of the platforms that the file has too, within two frames
};

double mean_size(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double x : values) sum += std::abs(x);
  return sum / static_cast<double>(values.size());
}

// Events that laboratories marked, of both feet and also where there is no platform. In sample 4
// the right platform is pressed 78 ms before the marked strike, which the markers confirm.
TEST(GaitEvents, AgreeWithThoseThatLaboratoriesMarked) {
  const std::filesystem::path folder = "../shared/data/c3d.org";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no ../shared/data";
  using Method = KinematicEventOptions::Method;
  for (const Published& p :
       {Published{"sample_03/gait-pig.c3d", 4}, Published{"sample_03/gait-pig-nz.c3d", 2},
        Published{"sample_04/sub_labels.c3d", 3}, Published{"sample_09/PlugInC3D.c3d", 4}}) {
    const C3dFile file = read_c3d(folder / p.file);
    const Vector3d up = Vector3d::UnitZ();
    const auto marked = events_from_file(file.events);
    const auto forces =
        events_from_forces(force_signals(compute_forces(file).recordings), &file.markers, up);
    std::vector<double> by_forces = differences(forces, marked);
    std::erase_if(by_forces, [&](double d) { return std::abs(d) > 2.0 / file.markers.rate; });
    EXPECT_EQ(by_forces.size(), p.by_forces) << p.file;
    for (const Method method : {Method::kCoordinates, Method::kFootVelocity}) {
      const std::vector<double> d =
          differences(marked, events_from_kinematics(file.markers, up, {.method = method}));
      // The record's ends hide an event or two.
      EXPECT_GE(d.size() + 2, marked.size()) << p.file;
      const std::string what = std::string(p.file) + (method == Method::kCoordinates ? " z" : " v");
      // The papers' means are within 16 ms, with deviations of the same size; strikes by
      // coordinates come early. Measured here: means of 18 to 23 ms, 58 ms the farthest.
      EXPECT_LT(mean_size(d), 0.03) << what;
      for (const double x : d) EXPECT_LT(std::abs(x), 0.065) << what;
    }
  }
}

}  // namespace
}  // namespace sinew
