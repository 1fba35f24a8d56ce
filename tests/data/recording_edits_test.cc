#include "data/recording_edits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "data/force_platform.h"

namespace sinew {
namespace {

MarkerTrajectories recording() {
  MarkerTrajectories markers;
  markers.names = {"LASI", "RASI", "C7"};
  markers.rate = 100.0;
  markers.time = Eigen::VectorXd::LinSpaced(11, 0.0, 0.1);
  markers.p_WM.resize(11, 9);
  for (int f = 0; f < 11; ++f) {
    markers.frame_numbers.push_back(f + 1);
    for (int c = 0; c < 9; ++c) markers.p_WM(f, c) = 10.0 * f + c;
  }
  return markers;
}

std::string refusal(const RecordingEdits& edits) {
  MarkerTrajectories markers = recording();
  try {
    edit_markers(markers, 1.0, edits);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

TEST(RecordingEdits, ReadsOptionsAsTheCheckWritesThem) {
  const NameSwap swap = parse_swap("R.Knee,L.Knee@0.25-1.5").value();
  EXPECT_EQ(swap.a, "R.Knee");
  EXPECT_EQ(swap.b, "L.Knee");
  EXPECT_EQ(*swap.from, 0.25);
  EXPECT_EQ(*swap.to, 1.5);
  EXPECT_FALSE(parse_swap("A,B").value().from);
  // Names may hold an @ and times may be negative.
  EXPECT_EQ(parse_swap("a@1,b").value().a, "a@1");
  EXPECT_EQ(*parse_drop("M@-0.2--0.1").value().from, -0.2);
  EXPECT_EQ(*parse_drop("M@-0.2--0.1").value().to, -0.1);
  EXPECT_EQ(parse_drop("M@home").value().name, "M@home");
  EXPECT_EQ(parse_rename("S:RKNE=R.Knee").value().from, "S:RKNE");
  EXPECT_EQ(parse_unloaded("0.1-0.5").value().plate, 0);
  EXPECT_EQ(parse_unloaded("2@0.1-0.5").value().plate, 2);
  for (const char* text : {"A", "A,", ",B", "A,A", "A,B,C", ""})
    EXPECT_FALSE(parse_swap(text)) << text;
  for (const char* text : {"A", "A=", "=B", ""}) EXPECT_FALSE(parse_rename(text)) << text;
  for (const char* text : {"", "1", "0.5-0.1", "0.1-0.1", "x@0-1", "0@0-1", "0-nan"}) {
    EXPECT_FALSE(parse_unloaded(text)) << text;
  }
  EXPECT_FALSE(parse_drop(""));
}

TEST(RecordingEdits, ExchangesWithinTimesBothEndsIncluded) {
  MarkerTrajectories markers = recording();
  RecordingEdits edits;
  edits.swaps = {{"LASI", "C7", 0.03, 0.05}};
  edit_markers(markers, 1.0, edits);
  const MarkerTrajectories before = recording();
  for (int f = 0; f < 11; ++f) {
    const bool within = f >= 3 && f <= 5;
    EXPECT_EQ(markers.position(f, 0), before.position(f, within ? 2 : 0)) << f;
    EXPECT_EQ(markers.position(f, 2), before.position(f, within ? 0 : 2)) << f;
    EXPECT_EQ(markers.position(f, 1), before.position(f, 1)) << f;
  }
  edit_markers(markers, 1.0, edits);
  EXPECT_EQ(markers, before);
}

TEST(RecordingEdits, DropsRenamesAndScalesInOrder) {
  MarkerTrajectories markers = recording();
  RecordingEdits edits;
  edits.unit = "mm";
  edits.drops = {{"C7", {}, {}}, {"RASI", 0.0, 0.015}};
  edits.swap_sides = true;
  edits.renames = {{"RASI", "ASIS"}};  // was the left one until sides were exchanged
  edit_markers(markers, 1.0, edits);
  EXPECT_EQ(markers.names, (std::vector<std::string>{"ASIS", "LASI"}));
  EXPECT_EQ(markers.p_WM.cols(), 6);
  EXPECT_DOUBLE_EQ(markers.p_WM(4, 1), 0.041);
  EXPECT_TRUE(std::isnan(markers.p_WM(1, 3)));
  EXPECT_DOUBLE_EQ(markers.p_WM(2, 3), 0.023);
}

TEST(RecordingEdits, SaysWhatDoesNotFit) {
  RecordingEdits edits;
  edits.drops = {{"T10", {}, {}}};
  EXPECT_EQ(refusal(edits), "--drop names 'T10', which is no marker of the recording");
  edits = {};
  edits.swaps = {{"LASI", "RASI", 1.0, 2.0}};
  EXPECT_EQ(refusal(edits), "--swap: no frame lies between 1 s and 2 s");
  edits = {};
  edits.renames = {{"LASI", "C7"}};
  EXPECT_EQ(refusal(edits), "--rename: there is a marker 'C7' already; drop or rename it first");
  edits = {};
  edits.drops = {{"LASI", {}, {}}, {"RASI", {}, {}}, {"C7", {}, {}}};
  EXPECT_EQ(refusal(edits), "--drop leaves no marker: leave one out of it");
  edits = {};
  edits.unit = "mile";
  EXPECT_EQ(refusal(edits), "--unit mile is no unit of length: give mm, cm, m, in or ft");
}

// Two platforms' channels, of which only the first's are platforms' by the parameters.
C3dFile laboratory() {
  C3dFile file;
  file.markers = recording();
  file.analog.labels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz", "EMG"};
  file.analog.units = {"N", "N", "N", "Nmm", "Nmm", "Nmm", "V"};
  file.analog.rate = 1000.0;
  file.analog.samples_per_frame = 10;
  file.analog.values.setZero(110, 7);
  file.quality.residual.setConstant(11, 3, 1e-3f);
  file.quality.cameras.setZero(11, 3);
  set_parameter(file.groups, "FORCE_PLATFORM", C3dParameter::of_integers("USED", {}, {1}));
  set_parameter(file.groups, "FORCE_PLATFORM", C3dParameter::of_integers("TYPE", {1}, {2}));
  set_parameter(
      file.groups, "FORCE_PLATFORM",
      C3dParameter::of_reals("CORNERS", {3, 4, 1}, {500, 400, 0, 0, 400, 0, 0, 0, 0, 500, 0, 0}));
  set_parameter(file.groups, "FORCE_PLATFORM",
                C3dParameter::of_reals("ORIGIN", {3, 1}, {0, 0, -40}));
  set_parameter(file.groups, "FORCE_PLATFORM",
                C3dParameter::of_integers("CHANNEL", {6, 1}, {1, 2, 3, 4, 5, 6}));
  return file;
}

TEST(RecordingEdits, TakesALineOffTheChannelsOfPlatformsOnly) {
  C3dFile file = laboratory();
  for (int i = 0; i < 110; ++i) file.analog.values.row(i).setConstant(2.0 + 0.5 * i);
  RecordingEdits edits;
  // Means of samples 0 to 19 and 80 to 99, about 9.5 and 89.5.
  edits.unloaded = {{1, 0.08, 0.1}, {1, 0.0, 0.02}};
  edit_recording(file, edits);
  EXPECT_NEAR(file.analog.values(0, 2), -0.5 * 9.5, 1e-9);
  for (int i = 10; i < 90; ++i) EXPECT_NEAR(file.analog.values(i, 2), 0.0, 1e-9) << i;
  EXPECT_EQ(file.analog.values(50, 6), 2.0 + 0.5 * 50);
  edits.unloaded = {{2, 0.0, 0.02}};
  EXPECT_THROW(edit_recording(file, edits), std::invalid_argument);
  edits.unloaded = {{1, 0.2, 0.3}};
  EXPECT_THROW(edit_recording(file, edits), std::invalid_argument);
}

TEST(RecordingEdits, MovesAllChannelsInTime) {
  C3dFile file = laboratory();
  for (int i = 0; i < 110; ++i) file.analog.values.row(i).setConstant(i);
  RecordingEdits edits;
  edits.shift_forces = 0.005;
  edit_recording(file, edits);
  EXPECT_EQ(file.analog.values(50, 0), 45.0);
  EXPECT_EQ(file.analog.values(2, 6), 0.0);
  edits.shift_forces = -0.005;
  edit_recording(file, edits);
  EXPECT_EQ(file.analog.values(50, 0), 50.0);
  EXPECT_EQ(file.analog.values(109, 0), 104.0);
}

TEST(RecordingEdits, KeepsPlatformsWhereOnlyMarkersHaveAnotherUnit) {
  RecordingEdits edits;
  edits.unit = "m";
  // Corners in millimetres, as the file says: they stay where they are in metres.
  C3dFile file = laboratory();
  std::vector<Warning> ignored;
  const auto before = find_force_platforms(file, ignored);
  ASSERT_TRUE(before.at(0).usable());
  edit_recording(file, edits);
  EXPECT_EQ(file.unit, "m");
  const auto after = find_force_platforms(file, ignored);
  ASSERT_TRUE(after.at(0).usable()) << after[0].problem;
  EXPECT_LT((after[0].p_WC - before[0].p_WC).norm(), 1e-6);
  EXPECT_DOUBLE_EQ(file.markers.p_WM(3, 1), 31000.0);
  // Corners in metres under the name of millimetres: the new unit makes sense of them.
  file = laboratory();
  set_parameter(
      file.groups, "FORCE_PLATFORM",
      C3dParameter::of_reals("CORNERS", {3, 4, 1}, {.5f, .4f, 0, 0, .4f, 0, 0, 0, 0, .5f, 0, 0}));
  EXPECT_FALSE(find_force_platforms(file, ignored).at(0).usable());
  edit_recording(file, edits);
  EXPECT_TRUE(find_force_platforms(file, ignored).at(0).usable());
}

TEST(RecordingEdits, DropsAMarkersQualityWithIt) {
  C3dFile file = laboratory();
  file.quality.residual(4, 2) = 5.0f;
  RecordingEdits edits;
  edits.drops = {{"LASI", {}, {}}};
  edit_recording(file, edits);
  EXPECT_EQ(file.quality.residual.cols(), 2);
  EXPECT_EQ(file.quality.residual(4, 1), 5.0f);
  EXPECT_EQ(file.quality.cameras.cols(), 2);
}

}  // namespace
}  // namespace sinew
