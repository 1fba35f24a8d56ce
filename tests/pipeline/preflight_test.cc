#include "pipeline/preflight.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <random>

#include "data/c3d_writer.h"
#include "data/marker_names.h"
#include "data/preflight_gaps.h"
#include "data/preflight_markers.h"
#include "data/preflight_order.h"
#include "data/preflight_rate.h"
#include "data/preflight_sides.h"
#include "data/preflight_swaps.h"
#include "data/preflight_timing.h"
#include "data/preflight_units.h"
#include "data/recording_edits.h"
#include "dynamics/reference_recording.h"
#include "model/marker_fit.h"
#include "model/whole_body.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// The embedded walk of the simplified body, made once.
const ReferenceRecording& walk() {
  static const ReferenceRecording recording = [] {
    WholeBodyOptions body;
    body.level = WholeBodyOptions::Level::kSimplified;
    return make_reference_recording(whole_body(body), reference_walk());
  }();
  return recording;
}

const LaboratoryAxes& model_axes() {
  static const LaboratoryAxes axes = [] {
    LaboratoryAxes a;
    a.up = {Vector3d::UnitY(), 1.0, ""};
    a.forward = {Vector3d::UnitX(), 1.0, ""};
    return a;
  }();
  return axes;
}

std::vector<Finding> of_kind(const std::vector<Finding>& all, const std::string& kind) {
  std::vector<Finding> found;
  std::copy_if(all.begin(), all.end(), std::back_inserter(found),
               [&](const Finding& f) { return f.kind == kind; });
  return found;
}

std::string to_text(const std::vector<Finding>& findings) {
  std::string text;
  for (const Finding& f : findings) {
    text += std::string(to_string(f.severity)) + " " + f.kind + " " + f.where + ": " + f.text +
            " {" + remedy(f) + "}\n";
  }
  return text;
}

// What `flags` say, as `sinew convert` would read them.
RecordingEdits edits_of(const std::vector<Finding>& findings) {
  RecordingEdits edits;
  for (const Finding& finding : findings) {
    for (std::size_t i = 0; i < finding.flags.size(); ++i) {
      const std::string& flag = finding.flags[i];
      if (flag == "--swap-sides") {
        edits.swap_sides = true;
        continue;
      }
      const std::string value = finding.flags.at(++i);
      if (flag == "--unit") edits.unit = value;
      if (flag == "--swap") edits.swaps.push_back(parse_swap(value).value());
      if (flag == "--drop") edits.drops.push_back(parse_drop(value).value());
      if (flag == "--rename") edits.renames.push_back(parse_rename(value).value());
      if (flag == "--shift-forces") edits.shift_forces = std::stod(value);
    }
  }
  return edits;
}

std::vector<Finding> check(const MarkerTrajectories& markers, const TimeTable* forces = nullptr,
                           double metres_per_unit = 1e-3) {
  PreflightInputs inputs;
  PreflightRecording recording;
  recording.path = "walk.trc";
  recording.markers = &markers;
  recording.metres_per_unit = metres_per_unit;
  recording.labels = markers.names;
  inputs.recordings.push_back(recording);
  if (forces) {
    PreflightRecording table;
    table.path = "grf.mot";
    table.table = forces;
    inputs.recordings.push_back(table);
  }
  inputs.model = &walk().model;
  return run_preflight(inputs);
}

void exchange(MarkerTrajectories& markers, int a, int b, int first, int end) {
  const RowMatrix kept = markers.p_WM.block(first, 3 * a, end - first, 3);
  markers.p_WM.block(first, 3 * a, end - first, 3) =
      markers.p_WM.block(first, 3 * b, end - first, 3).eval();
  markers.p_WM.block(first, 3 * b, end - first, 3) = kept;
}

TEST(Preflight, FindsNothingButTheAxesInTheCleanWalk) {
  const std::vector<Finding> findings = check(walk().markers, &walk().forces);
  ASSERT_EQ(findings.size(), 1u) << to_text(findings);
  EXPECT_EQ(findings[0].kind, "axes");
  EXPECT_EQ(findings[0].severity, Finding::Severity::kNote);
  EXPECT_TRUE(findings[0].text.starts_with("up is y")) << findings[0].text;
  EXPECT_NE(findings[0].text.find("forward is x"), std::string::npos) << findings[0].text;
}

TEST(Preflight, NoiseSoftTissueAndGapsRaiseNoFalseAlarm) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    WholeBodyOptions body;
    body.level = WholeBodyOptions::Level::kSimplified;
    ReferenceRecordingOptions options;
    options.artifacts.noise = 1e-3;
    options.artifacts.soft_tissue = 0.01;
    options.artifacts.occlusion = 0.05;
    options.artifacts.seed = seed;
    const ReferenceRecording noisy =
        make_reference_recording(whole_body(body), reference_walk(), options);
    const std::vector<Finding> findings = check(noisy.markers, &noisy.forces);
    for (const Finding& finding : findings) {
      EXPECT_TRUE(finding.kind == "axes" || finding.kind == "gap") << to_text({finding});
      EXPECT_EQ(finding.severity, Finding::Severity::kNote) << to_text({finding});
    }
  }
}

TEST(Preflight, TellsTheUnitOfAGiantAndADwarf) {
  struct Case {
    double factor, metres_per_unit;
    const char* unit;
  };
  // Metres called millimetres, millimetres called metres, centimetres called either.
  for (const Case& c :
       {Case{1e-3, 1e-3, "m"}, Case{1e3, 1.0, "mm"}, Case{0.1, 1e-3, "cm"}, Case{1e2, 1.0, "cm"}}) {
    MarkerTrajectories markers = walk().markers;
    markers.p_WM *= c.factor;
    const std::vector<Finding> found = find_unit_faults(markers, c.metres_per_unit);
    ASSERT_EQ(found.size(), 1u) << c.factor;
    EXPECT_EQ(found[0].severity, Finding::Severity::kError);
    EXPECT_EQ(found[0].flags, (std::vector<std::string>{"--unit", c.unit})) << found[0].text;
    edit_markers(markers, c.metres_per_unit, edits_of(found));
    EXPECT_TRUE(find_unit_faults(markers, 1.0).empty());
    EXPECT_LT((markers.p_WM - walk().markers.p_WM).cwiseAbs().maxCoeff(), 1e-12);
    // Without names that tell, only sizes do, and ten times too small may be a hand.
    for (std::string& name : markers.names) name = "m" + name;
    if (c.factor == 0.1) continue;
    markers.p_WM *= c.factor;
    EXPECT_EQ(edits_of(find_unit_faults(markers, c.metres_per_unit)).unit, c.unit);
  }
  EXPECT_TRUE(find_unit_faults(walk().markers, 1e-3).empty());
}

TEST(Preflight, FindsExchangedTrajectoriesAndTheirFrames) {
  const int frames = walk().markers.frame_count();
  const int count = walk().markers.marker_count();
  std::mt19937 random(7);
  int found_swaps = 0;
  for (int trial = 0; trial < 60; ++trial) {
    MarkerTrajectories markers = walk().markers;
    const int a = static_cast<int>(random() % static_cast<unsigned>(count));
    int b = static_cast<int>(random() % static_cast<unsigned>(count - 1));
    if (b >= a) ++b;
    const int first = 5 + static_cast<int>(random() % static_cast<unsigned>(frames - 60));
    const int end = first + 1 + static_cast<int>(random() % 40u);
    // Markers that meet cannot be told apart there.
    bool apart = true;
    for (const int f : {first - 1, first, end - 1, end}) {
      apart = apart && (markers.position(f, a) - markers.position(f, b)).norm() > 0.06;
    }
    if (!apart) continue;
    exchange(markers, a, b, first, end);
    const std::vector<MarkerSwap> swaps = find_marker_swaps(markers);
    ASSERT_EQ(swaps.size(), 1u) << trial;
    EXPECT_EQ(swaps[0].a, std::min(a, b));
    EXPECT_EQ(swaps[0].b, std::max(a, b));
    EXPECT_EQ(swaps[0].first, first);
    EXPECT_EQ(swaps[0].last, end - 1);
    const std::vector<Finding> findings = find_swap_faults(markers);
    edit_markers(markers, 1.0, edits_of(findings));
    EXPECT_EQ(markers.p_WM, walk().markers.p_WM);
    ++found_swaps;
  }
  EXPECT_GT(found_swaps, 40);
  EXPECT_TRUE(find_marker_swaps(walk().markers).empty());
}

TEST(Preflight, FindsAHeelAndAToeThatAreExchangedAllTheTime) {
  LaboratoryAxes axes;
  axes.up.axis = Eigen::Vector3d::UnitY();
  axes.up.confidence = 1.0;
  EXPECT_TRUE(find_side_faults(walk().markers, axes).empty());
  for (const char* toe : {"LTOE", "LMT5"}) {
    MarkerTrajectories markers = walk().markers;
    exchange(markers, markers.find_marker("LHEE"), markers.find_marker(toe), 0,
             markers.frame_count());
    const std::vector<Finding> findings = find_side_faults(markers, axes);
    ASSERT_EQ(findings.size(), 1u) << toe;
    EXPECT_EQ(findings[0].kind, "swap");
    EXPECT_EQ(findings[0].flags, (std::vector<std::string>{"--swap", std::string("LHEE,") + toe}));
    edit_markers(markers, 1.0, edits_of(findings));
    EXPECT_TRUE(find_side_faults(markers, axes).empty()) << toe;
  }
}

TEST(Preflight, FindsMarkersOfOneLegInTheWrongOrder) {
  LaboratoryAxes axes;
  axes.up.axis = Eigen::Vector3d::UnitY();
  axes.up.confidence = 1.0;
  EXPECT_TRUE(find_order_faults(walk().markers, axes).empty());
  for (const auto& [high, low] :
       {std::pair{"LKNE", "LTIB"}, {"RKNE", "RANK"}, {"RTHI", "RKNE"}, {"LASI", "LKNE"}}) {
    MarkerTrajectories markers = walk().markers;
    exchange(markers, markers.find_marker(high), markers.find_marker(low), 0,
             markers.frame_count());
    const std::vector<Finding> findings = find_order_faults(markers, axes);
    ASSERT_EQ(findings.size(), 1u) << high;
    EXPECT_EQ(findings[0].flags,
              (std::vector<std::string>{"--swap", std::string(high) + "," + low}));
  }
  // Somebody who kneels all the time has both legs like that.
  MarkerTrajectories kneeling = walk().markers;
  for (const char* side : {"R", "L"}) {
    exchange(kneeling, kneeling.find_marker(side + std::string("KNE")),
             kneeling.find_marker(side + std::string("ANK")), 0, kneeling.frame_count());
  }
  EXPECT_TRUE(find_order_faults(kneeling, axes).empty());
}

// Names tell which part of an exchange that is not undone is wrong, also where it is the longer.
TEST(Preflight, TellsWhichPartOfAnExchangeIsWrong) {
  LaboratoryAxes axes;
  axes.up.axis = Eigen::Vector3d::UnitY();
  axes.up.confidence = 1.0;
  const MarkerTrajectories& right = walk().markers;
  const int frames = right.frame_count();
  const std::pair<const char*, const char*> pairs[] = {{"RKNE", "LKNE"}, {"RHEE", "RASI"}};
  for (const auto& [a, b] : pairs) {
    for (const auto& [first, end] :
         {std::pair{0, frames / 3}, std::pair{0, 2 * frames / 3}, std::pair{frames / 3, frames}}) {
      MarkerTrajectories markers = right;
      exchange(markers, right.find_marker(a), right.find_marker(b), first, end);
      const std::vector<Finding> findings = find_swap_faults(markers, axes);
      ASSERT_EQ(findings.size(), 1u) << a;
      ASSERT_FALSE(findings[0].flags.empty()) << a;
      edit_markers(markers, 1.0, edits_of(findings));
      EXPECT_EQ(markers.p_WM, right.p_WM) << a << " " << first << " " << end;
    }
  }
  // Two of one hand: nothing tells, so both are named and none is chosen.
  MarkerTrajectories markers = right;
  exchange(markers, right.find_marker("LFHD"), right.find_marker("LBHD"), frames / 3, frames);
  const std::vector<Finding> findings = find_swap_faults(markers, axes);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_TRUE(findings[0].flags.empty());
  EXPECT_NE(findings[0].advice.find("--swap LFHD,LBHD@0-"), std::string::npos)
      << findings[0].advice;
}

TEST(Preflight, FindsExchangesThroughNoiseAndShortGaps) {
  WholeBodyOptions body;
  body.level = WholeBodyOptions::Level::kSimplified;
  ReferenceRecordingOptions options;
  options.artifacts.noise = 5e-4;
  options.artifacts.mislabels = 3;
  int found = 0, wrong = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    options.artifacts.seed = seed;
    options.artifacts.mislabels = 0;
    const ReferenceRecording clean =
        make_reference_recording(whole_body(body), reference_walk(), options);
    MarkerTrajectories markers = clean.markers;
    MarkerArtifacts exchange_only;
    exchange_only.mislabels = 3;
    exchange_only.seed = seed;
    spoil_markers(exchange_only, markers);
    edit_markers(markers, 1.0, edits_of(find_swap_faults(markers)));
    // Samples that are still another marker's.
    const Eigen::Index off =
        ((markers.p_WM - clean.markers.p_WM).cwiseAbs().array() > 0.02).count();
    off == 0 ? ++found : ++wrong;
  }
  EXPECT_GE(found, 5) << wrong;
  // Both markers hidden while they exchange names.
  MarkerTrajectories markers = walk().markers;
  const int a = 0, b = markers.marker_count() - 1;
  exchange(markers, a, b, 80, 120);
  for (const int m : {a, b}) markers.p_WM.block(80, 3 * m, 4, 3).setConstant(std::nan(""));
  const std::vector<MarkerSwap> swaps = find_marker_swaps(markers);
  ASSERT_EQ(swaps.size(), 1u);
  EXPECT_EQ(swaps[0].first, 84);
  EXPECT_EQ(swaps[0].last, 119);
}

TEST(Preflight, FindsStaticAndHeldMarkers) {
  MarkerTrajectories markers = walk().markers;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 5e-4);
  const int still = 4, held = 9, frames = markers.frame_count();
  for (int f = 0; f < frames; ++f) {
    for (int k = 0; k < 3; ++k) markers.p_WM(f, 3 * still + k) = 0.3 * (k + 1) + noise(random);
  }
  for (int f = 61; f < 100; ++f) {
    markers.p_WM.row(f).segment<3>(3 * held) = markers.p_WM.row(60).segment<3>(3 * held).eval();
  }
  const std::vector<Finding> found = find_static_markers(markers);
  ASSERT_EQ(found.size(), 2u) << to_text(found);
  EXPECT_EQ(found[0].where, markers.names[4]);
  EXPECT_EQ(found[0].flags, (std::vector<std::string>{"--drop", markers.names[4]}));
  EXPECT_EQ(found[1].where, markers.names[9]);
  EXPECT_EQ(*found[1].first_frame, markers.frame_numbers[60]);
  EXPECT_EQ(*found[1].last_frame, markers.frame_numbers[99]);
  const int before = markers.marker_count();
  edit_markers(markers, 1.0, edits_of(found));
  EXPECT_EQ(markers.marker_count(), before - 1);
  EXPECT_TRUE(find_static_markers(markers).empty());
  EXPECT_TRUE(find_static_markers(walk().markers).empty());
  // Someone who stands still is not a recording of static markers.
  WholeBodyOptions body;
  body.level = WholeBodyOptions::Level::kSimplified;
  EXPECT_TRUE(find_static_markers(make_static_recording(whole_body(body))).empty());
}

TEST(Preflight, FindsMirroredNamesAndSinglePairs) {
  MarkerTrajectories markers = walk().markers;
  const std::vector<MarkerPair> pairs = find_marker_pairs(markers.names);
  ASSERT_GT(pairs.size(), 10u);
  EXPECT_TRUE(find_side_faults(markers, model_axes()).empty());
  for (const MarkerPair& pair : pairs) {
    std::swap(markers.names[static_cast<std::size_t>(pair.left)],
              markers.names[static_cast<std::size_t>(pair.right)]);
  }
  std::vector<Finding> found = find_side_faults(markers, model_axes());
  ASSERT_EQ(found.size(), 1u) << to_text(found);
  EXPECT_EQ(found[0].flags, std::vector<std::string>{"--swap-sides"});
  EXPECT_EQ(found[0].severity, Finding::Severity::kError);
  edit_markers(markers, 1.0, edits_of(found));
  EXPECT_EQ(markers, walk().markers);
  // Each pair by itself: all but those on the middle line are found, and no other.
  int single = 0;
  for (const MarkerPair& pair : pairs) {
    markers = walk().markers;
    std::swap(markers.names[static_cast<std::size_t>(pair.left)],
              markers.names[static_cast<std::size_t>(pair.right)]);
    found = find_side_faults(markers, model_axes());
    ASSERT_EQ(found.size(), 1u) << markers.names[static_cast<std::size_t>(pair.left)]
                                << to_text(found);
    edit_markers(markers, 1.0, edits_of(found));
    EXPECT_TRUE(find_side_faults(markers, model_axes()).empty());
    ++single;
  }
  EXPECT_EQ(single, static_cast<int>(pairs.size()));
}

TEST(Preflight, TellsBackwardWalkFromMirroredNames) {
  // The same walk played backwards: feet point against the way.
  MarkerTrajectories markers = walk().markers;
  markers.p_WM = walk().markers.p_WM.colwise().reverse().eval();
  const std::vector<Finding> found = find_side_faults(markers, model_axes());
  ASSERT_EQ(found.size(), 1u) << to_text(found);
  EXPECT_EQ(found[0].severity, Finding::Severity::kNote);
  EXPECT_NE(found[0].text.find("backwards"), std::string::npos);
}

TEST(Preflight, ListsGapsByLength) {
  MarkerTrajectories markers = walk().markers;  // 100 Hz
  const auto hide = [&](int marker, int first, int count) {
    markers.p_WM.block(first, 3 * marker, count, 3).setConstant(std::nan(""));
  };
  hide(0, 10, 10);
  hide(1, 20, 11);
  hide(2, 30, 50);
  hide(3, 40, 51);
  hide(4, 0, 30);  // comes late: no gap
  const std::vector<Finding> found = find_gap_faults(markers);
  ASSERT_EQ(found.size(), 3u) << to_text(found);
  EXPECT_EQ(found[0].severity, Finding::Severity::kWarning);
  EXPECT_EQ(found[0].where, markers.names[3]);
  EXPECT_EQ(found[1].where, markers.names[2] + " and " + markers.names[1]);
  EXPECT_EQ(found[2].where, markers.names[0]);
  EXPECT_EQ(found[2].flags, (std::vector<std::string>{"--max-gap", "0.1"}));
  const std::vector<MarkerGap> gaps = find_inner_gaps(markers);
  ASSERT_EQ(gaps.size(), 4u);
  EXPECT_EQ(gaps[0], (MarkerGap{3, 40, 51}));
  EXPECT_EQ(gaps[3], (MarkerGap{0, 10, 10}));
}

TEST(Preflight, FindsOddTimes) {
  MarkerTrajectories markers = walk().markers;
  EXPECT_TRUE(find_timing_faults(markers).empty());
  markers.frame_numbers.front() = 63;
  ASSERT_EQ(find_timing_faults(markers).size(), 1u);
  EXPECT_EQ(find_timing_faults(markers)[0].kind, "first frame");
  markers = walk().markers;
  markers.time[50] += 0.3 / markers.rate;
  std::vector<Finding> found = find_timing_faults(markers);
  ASSERT_EQ(found.size(), 1u) << to_text(found);
  EXPECT_EQ(found[0].flags, (std::vector<std::string>{"--rate", "100"}));
  markers = walk().markers;
  markers.rate = 50.0;
  found = find_timing_faults(markers);
  ASSERT_EQ(found.size(), 1u) << to_text(found);
  EXPECT_NE(found[0].text.find("the file's rate is 50 Hz"), std::string::npos);
  markers.rate = 30.0;
  EXPECT_EQ(find_timing_faults(markers).size(), 2u);
}

TEST(Preflight, FindsDuplicateLabelsAndPlaces) {
  MarkerTrajectories markers = walk().markers;
  std::vector<std::string> labels = markers.names;
  EXPECT_TRUE(find_duplicate_markers(markers, labels).empty());
  const std::string name = markers.names[3];
  labels[7] = name;
  markers.names[7] = name + "_2";
  // The one that keeps its name is measured less.
  markers.p_WM.block(0, 9, 80, 3).setConstant(std::nan(""));
  std::vector<Finding> found = find_duplicate_markers(markers, labels);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].flags,
            (std::vector<std::string>{"--drop", name, "--rename", name + "_2=" + name}));
  edit_markers(markers, 1.0, edits_of(found));
  EXPECT_TRUE(find_duplicate_markers(markers, markers.names).empty());
  markers = walk().markers;
  markers.p_WM.middleCols(12, 3) = markers.p_WM.middleCols(30, 3).array() + 2e-4;
  found = find_duplicate_markers(markers, markers.names);
  ASSERT_EQ(found.size(), 1u) << to_text(found);
  EXPECT_EQ(found[0].where, markers.names[4] + " = " + markers.names[10]);
}

TEST(Preflight, FindsForcesOutOfStep) {
  for (const double shift : {-0.2, -0.1, -0.05, 0.05, 0.08, 0.15, 0.3}) {
    TimeTable forces = walk().forces;
    forces.time.array() += shift;
    const std::vector<Finding> found = of_kind(check(walk().markers, &forces), "clock");
    ASSERT_EQ(found.size(), 1u) << shift;
    EXPECT_EQ(found[0].flags[0], "--shift-forces");
    const double back = std::stod(found[0].flags[1]);
    EXPECT_NEAR(back, -shift, 0.02) << found[0].text;
    forces.time.array() += back;
    EXPECT_TRUE(of_kind(check(walk().markers, &forces), "clock").empty()) << shift;
  }
}

TEST(Preflight, FindsForcesInAnotherFrame) {
  TimeTable forces = walk().forces;
  for (const char* column : {"ground_force_r_pz", "ground_force_l_pz"}) {
    const int at = forces.find_column(column);
    ASSERT_GE(at, 0);
    forces.values.col(at).array() += 0.6;
  }
  const std::vector<Finding> found = of_kind(check(walk().markers, &forces), "place");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Finding::Severity::kWarning);
}

TEST(Preflight, FindsAModelOfAnotherSize) {
  const MusculoskeletalModel& model = walk().model;
  EXPECT_TRUE(find_size_faults(walk().markers, model).empty());
  for (const double factor : {0.88, 0.93, 1.07, 1.15}) {
    MarkerTrajectories markers = walk().markers;
    markers.p_WM *= factor;
    const std::vector<Finding> found = find_size_faults(markers, model);
    ASSERT_EQ(found.size(), 1u) << factor << to_text(found);
    EXPECT_EQ(found[0].kind, "size");
    char text[16];
    std::snprintf(text, sizeof text, "%.3f times", factor);
    EXPECT_NE(found[0].text.find(text), std::string::npos) << found[0].text;
    EXPECT_NE(found[0].text.find(factor < 1.0 ? "too big" : "too small"), std::string::npos);
  }
}

TEST(Preflight, FindsMarkersThatTheModelHasUnderAnotherName) {
  MarkerTrajectories markers = walk().markers;
  EXPECT_TRUE(find_unmatched_markers(markers, walk().model).empty());
  const std::string name = markers.names[2];
  markers.names[2] = "Subject:" + name;
  std::transform(name.begin(), name.end(), markers.names[2].begin() + 8,
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  markers.names[5] = "strange";
  std::vector<Finding> found = find_unmatched_markers(markers, walk().model);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].flags, (std::vector<std::string>{"--rename", markers.names[2] + "=" + name}));
  edit_markers(markers, 1.0, edits_of(found));
  EXPECT_EQ(markers.names[2], name);
  for (std::string& other : markers.names) other = "x" + other;
  found = find_unmatched_markers(markers, walk().model);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].severity, Finding::Severity::kError);
}

}  // namespace
}  // namespace sinew
