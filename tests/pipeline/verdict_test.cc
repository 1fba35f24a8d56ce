#include "pipeline/verdict.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/verdict_report.h"

namespace sinew {
namespace {

using Weight = VerdictReason::Weight;
using Use = JointVerdict::Use;
using Names = std::vector<std::string>;

const VerdictReason* find(const std::vector<VerdictReason>& reasons, const std::string& code) {
  for (const VerdictReason& r : reasons) {
    if (r.code == code) return &r;
  }
  return nullptr;
}

// One reason of this code with this weight and figure, or the test fails.
void expect_reason(const std::vector<VerdictReason>& reasons, const std::string& code,
                   Weight weight, double figure, double limit, const std::string& unit) {
  const VerdictReason* r = find(reasons, code);
  ASSERT_NE(r, nullptr) << code;
  EXPECT_EQ(r->weight, weight) << code;
  EXPECT_NEAR(r->figure, figure, 1e-9 * std::abs(figure)) << code;
  EXPECT_NEAR(r->limit, limit, 1e-9 * std::abs(limit)) << code;
  EXPECT_EQ(r->unit, unit) << code;
  EXPECT_FALSE(r->source.empty()) << code;
  EXPECT_FALSE(r->remedy.empty()) << code;
}

KinematicsEvidence good_kinematics() {
  KinematicsEvidence k;
  k.frames = 100;
  k.marker_rms = 0.010;
  k.markers = {{"RKNE", 100, 0.010, 0.020, 1, {"hip_r"}},
               {"LKNE", 100, 0.011, 0.02, -1, {"hip_l"}}};
  k.coordinates = {{"hip_r", "", true, 0.8, 0.0, false}, {"hip_l", "hip_r", true, 0.7, 0.0, false}};
  return k;
}

TEST(JudgeKinematics, FindsNothingInAGoodTrial) {
  EXPECT_TRUE(judge_kinematics(good_kinematics()).empty());
}

TEST(JudgeKinematics, HoldsTheMarkersRmsAgainstHicksLimit) {
  KinematicsEvidence k = good_kinematics();
  k.marker_rms = 0.020;  // the limit itself is kept
  EXPECT_EQ(find(judge_kinematics(k), "marker-rms"), nullptr);
  k.marker_rms = 0.0225;
  expect_reason(judge_kinematics(k), "marker-rms", Weight::kRemark, 22.5, 20.0, "mm");
  EXPECT_EQ(find(judge_kinematics(k), "marker-rms")->source, "Hicks et al. 2015");
  EXPECT_TRUE(find(judge_kinematics(k), "marker-rms")->angles.empty());
  k.marker_rms = 0.603;
  const std::vector<VerdictReason> reasons = judge_kinematics(k);
  expect_reason(reasons, "marker-rms", Weight::kUnusable, 603.0, 20.0, "mm");
  EXPECT_EQ(find(reasons, "marker-rms")->angles, (Names{"hip_r", "hip_l"}));
  EXPECT_EQ(find(reasons, "marker-rms")->torques, (Names{"hip_r", "hip_l"}));
  EXPECT_NE(find(reasons, "marker-rms")->remedy.find("unit"), std::string::npos);
  k.marker_rms = std::nan("");
  EXPECT_EQ(find(judge_kinematics(k), "marker-rms"), nullptr);
}

TEST(JudgeKinematics, NamesSingleMarkersTheFarthestFirst) {
  KinematicsEvidence k = good_kinematics();
  k.markers[0].max = 0.045;
  k.markers[1].max = 0.120;
  k.markers[1].rms = 0.105;
  const std::vector<VerdictReason> reasons = judge_kinematics(k);
  expect_reason(reasons, "marker-max", Weight::kRemark, 120.0, 40.0, "mm");
  EXPECT_NE(find(reasons, "marker-max")->text.find("LKNE, RKNE"), std::string::npos);
  // A marker that is off all the time takes its joint's angles away.
  expect_reason(reasons, "lost-marker", Weight::kRemark, 105.0, 100.0, "mm");
  EXPECT_EQ(find(reasons, "lost-marker")->angles, (Names{"hip_l"}));
}

TEST(JudgeKinematics, CountsFrames) {
  KinematicsEvidence k = good_kinematics();
  k.unconverged = 1;
  k.unmeasured = 10;
  k.filled = 0.2;
  const std::vector<VerdictReason> reasons = judge_kinematics(k);
  expect_reason(reasons, "unconverged", Weight::kUnusable, 1.0, 0.0, "%");
  expect_reason(reasons, "unmeasured-frames", Weight::kRemark, 10.0, 0.0, "%");
  expect_reason(reasons, "filled-share", Weight::kRemark, 20.0, 10.0, "%");
  k.fallen = 0.6;
  expect_reason(judge_kinematics(k), "not-upright", Weight::kRemark, 60.0, 50.0, "% of the frames");
  k.unmeasured = 51;
  EXPECT_EQ(find(judge_kinematics(k), "unmeasured-frames")->weight, Weight::kUnusable);
}

TEST(JudgeKinematics, NamesCoordinatesAtTheEndOfTheirRange) {
  KinematicsEvidence k = good_kinematics();
  k.coordinates[0].on_bound = 0.2;
  k.coordinates[1].on_bound = 0.6;
  const std::vector<VerdictReason> reasons = judge_kinematics(k);
  expect_reason(reasons, "on-bound", Weight::kRemark, 60.0, 10.0, "% of the frames");
  EXPECT_NE(find(reasons, "on-bound")->text.find("hip_l, hip_r"), std::string::npos);
  EXPECT_EQ(find(reasons, "on-bound")->angles, (Names{"hip_l"}));
  k.coordinates[0].on_bound = k.coordinates[1].on_bound = 0.1;
  EXPECT_EQ(find(judge_kinematics(k), "on-bound"), nullptr);
}

TEST(JudgeKinematics, ComparesTheSides) {
  KinematicsEvidence k = good_kinematics();
  // sqrt((30² · 100 + 40² · 300) / 400) = sqrt(1425) mm, on the left; 10 mm on the right.
  k.markers[1].rms = 0.030;
  k.markers.push_back({"LANK", 300, 0.040, 0.040, -1, {"hip_l"}});
  expect_reason(judge_kinematics(k), "side-rms", Weight::kRemark, std::sqrt(1425.0), 25.0, "mm");
  k.markers[0].rms = 0.020;  // 38 is less than 2.5 times 20
  EXPECT_EQ(find(judge_kinematics(k), "side-rms"), nullptr);

  k = good_kinematics();
  k.coordinates[0].range = 1.2;
  k.coordinates[1].range = 0.3;
  expect_reason(judge_kinematics(k), "side-range", Weight::kRemark, 0.9 * 180.0 / std::numbers::pi,
                0.7 * 180.0 / std::numbers::pi, "degrees");
  k.coordinates[1].undetermined = true;
  EXPECT_EQ(find(judge_kinematics(k), "side-range"), nullptr);
  k.coordinates[1].undetermined = false;
  k.coordinates[1].range = 0.45;  // a third would be 0.4
  EXPECT_EQ(find(judge_kinematics(k), "side-range"), nullptr);
}

TEST(JudgeKinematics, HoldsTheMovementAgainstTheStaticTrial) {
  KinematicsEvidence k = good_kinematics();
  k.marker_rms = 0.0153;
  k.static_rms = 0.001;
  expect_reason(judge_kinematics(k), "static-rms", Weight::kRemark, 15.3, 11.0, "mm");
  k.static_rms = 0.006;
  EXPECT_EQ(find(judge_kinematics(k), "static-rms"), nullptr);
}

// 75 kg walk over platforms that know all.
DynamicsEvidence good_dynamics() {
  DynamicsEvidence d;
  d.floating = d.loads_given = d.by_platforms = true;
  d.weight = 75.0 * 9.80665;
  d.height = 1.75;
  d.frames = d.known = 200;
  d.peak_load = 800.0;
  d.mean_vertical_load = d.weight;
  d.vertical_load_rms = 740.0;
  d.horizontal_load_rms = 90.0;
  d.carried_mass = 75.0;
  d.root = {8.0, 30.0, 7.0, 20.0};
  d.feet = {{"right", 200, "all", {"root", "hip_r"}}, {"left", 200, "all", {"root", "hip_l"}}};
  d.supporting = {"root", "hip_r", "hip_l"};
  d.coordinates = {"root", "hip_r", "hip_l", "shoulder"};
  d.mass_of_some_frames = false;
  return d;
}

TEST(JudgeDynamics, FindsNothingInAGoodTrial) {
  EXPECT_TRUE(judge_dynamics(good_dynamics()).empty());
  EXPECT_TRUE(partly_known_torques(good_dynamics()).empty());
}

TEST(JudgeDynamics, HoldsTheRootAgainstHicksLimits) {
  DynamicsEvidence d = good_dynamics();
  d.root.force_rms = 48.0;   // 6 % of 800 N
  d.root.moment_rms = 28.0;  // 2 % of 1400 N m
  std::vector<VerdictReason> reasons = judge_dynamics(d);
  expect_reason(reasons, "residual-force", Weight::kRemark, 6.0, 5.0,
                "% of the largest ground force");
  expect_reason(reasons, "residual-moment", Weight::kRemark, 2.0, 1.0, "% of height times that");
  EXPECT_TRUE(find(reasons, "residual-force")->torques.empty());
  d.root.force_rms = 5e6;
  d.root.moment_rms = 155000.0;
  reasons = judge_dynamics(d);
  EXPECT_EQ(find(reasons, "residual-force")->weight, Weight::kUnusable);
  EXPECT_EQ(find(reasons, "residual-moment")->weight, Weight::kUnusable);
  EXPECT_EQ(find(reasons, "residual-force")->torques, d.coordinates);
  // Tenfold and twentyfold are still remarks.
  d.root.force_rms = 400.0;
  d.root.moment_rms = 280.0;
  reasons = judge_dynamics(d);
  EXPECT_EQ(find(reasons, "residual-force")->weight, Weight::kRemark);
  EXPECT_EQ(find(reasons, "residual-moment")->weight, Weight::kRemark);
}

TEST(JudgeDynamics, SaysWhereLoadsAreMissing) {
  DynamicsEvidence d = good_dynamics();
  d.feet[0].complete = 50;
  d.known = 50;
  std::vector<VerdictReason> reasons = judge_dynamics(d);
  expect_reason(reasons, "loads-missing", Weight::kRemark, 25.0, 100.0, "% of the frames");
  EXPECT_TRUE(find(reasons, "loads-missing")->torques.empty());
  EXPECT_EQ(partly_known_torques(d), (Names{"root", "hip_r"}));
  d.feet[0].complete = 0;
  d.known = 0;
  reasons = judge_dynamics(d);
  EXPECT_EQ(find(reasons, "loads-missing")->weight, Weight::kUnusable);
  EXPECT_EQ(find(reasons, "residual-force"), nullptr);  // of nothing
}

TEST(JudgeDynamics, WithoutLoadsOnlyWhatCarriesTheBodyIsUnknown) {
  DynamicsEvidence d = good_dynamics();
  d.loads_given = false;
  const std::vector<VerdictReason> reasons = judge_dynamics(d);
  ASSERT_EQ(reasons.size(), 1u);
  EXPECT_EQ(reasons[0].code, "no-loads");
  EXPECT_EQ(reasons[0].weight, Weight::kRemark);
  EXPECT_EQ(reasons[0].torques, d.supporting);
  EXPECT_TRUE(reasons[0].angles.empty());
  d.floating = false;  // an arm that is bolted to the ground needs none
  EXPECT_TRUE(judge_dynamics(d).empty());
}

TEST(JudgeDynamics, LooksAtTheLoadsDirectionAndSum) {
  DynamicsEvidence d = good_dynamics();
  d.mean_vertical_load = -700.0;
  expect_reason(judge_dynamics(d), "loads-pull-down", Weight::kUnusable, -700.0, 0.0, "N");
  d = good_dynamics();
  d.horizontal_load_rms = 741.0;
  expect_reason(judge_dynamics(d), "loads-sideways", Weight::kRemark, 741.0, 740.0, "N");
  d = good_dynamics();
  d.pushes = {{"", "", "x", 90.0, 95.0, 0.97}, {"", "", "z", 30.0, 28.0, -0.6}};
  expect_reason(judge_dynamics(d), "loads-turned", Weight::kUnusable, 0.6, 0.5, "");
  EXPECT_EQ(find(judge_dynamics(d), "loads-turned")->torques, d.supporting);
  d.pushes[1].load_rms = 0.01 * d.weight;  // little, as of an offset
  EXPECT_TRUE(judge_dynamics(d).empty());
  // One foot's alone spoils the sum as well.
  d.pushes = {{"", "", "x", 90.0, 95.0, -0.6},
              {"calcn_r", "", "x", 80.0, 95.0, 0.2},
              {"calcn_l", "", "x", 80.0, 95.0, -0.97}};
  const std::vector<VerdictReason> turned = judge_dynamics(d);
  ASSERT_EQ(turned.size(), 1u);
  expect_reason(turned, "loads-turned", Weight::kUnusable, 0.97, 0.5, "");
  EXPECT_EQ(turned[0].text.substr(0, 27), "the force on calcn_l pushes");
  // Or one contact's, which its whole load hides.
  d.pushes = {{"calcn_r", "", "x", 80.0, 95.0, 0.1},
              {"calcn_r", "from 1.00 s to 1.60 s", "x", 80.0, 95.0, -0.9}};
  EXPECT_EQ(judge_dynamics(d).at(0).text.substr(0, 49),
            "the force on calcn_r pushes from 1.00 s to 1.60 s");
  d.pushes = {{"calcn_r", "", "x", 4.0, 95.0, 0.1, 500.0}};
  expect_reason(judge_dynamics(d), "loads-no-push", Weight::kUnusable, 4.0, 4.75, "N");
  d.pushes[0].acts_rms = 50.0;  // the other foot stands
  EXPECT_TRUE(judge_dynamics(d).empty());
  d.pushes[0].acts_rms = 500.0;
  d.pushes[0].load_rms = 5.0;
  EXPECT_TRUE(judge_dynamics(d).empty());
  d.pushes.clear();
  d.turns = {{"", "", "x is z, z is x", 90.0, 0.3}, {"calcn_r", "", "x is -z, z is x", 80.0, 0.9}};
  expect_reason(judge_dynamics(d), "loads-turned", Weight::kUnusable, 30.0, 57.7, "% of it");
  EXPECT_NE(judge_dynamics(d)[0].text.find("with x is z, z is x a part"), std::string::npos);
  d.turns[0].left = 0.6;
  EXPECT_TRUE(judge_dynamics(d).empty());
  d.turns.clear();
  d.pulls = {{"calcn_r", 300.0}, {"calcn_l", -300.0}};
  expect_reason(judge_dynamics(d), "loads-pull-down", Weight::kUnusable, -300.0, 0.0, "N");
  EXPECT_EQ(judge_dynamics(d)[0].text, "the force on calcn_l pulls down");
  d.pulls[1].mean = -10.0;  // an offset
  EXPECT_TRUE(judge_dynamics(d).empty());
  d = good_dynamics();
  d.carried_mass = 60.0;  // the model has a quarter more
  expect_reason(judge_dynamics(d), "mass-carried", Weight::kRemark, 25.0, 3.0, "%");
  d.carried_mass = 75.0 / 2.2046;  // entered in pounds
  expect_reason(judge_dynamics(d), "mass-carried", Weight::kUnusable, 120.46, 3.0, "%");
  d.carried_mass = 68.0;
  d.mass_of_some_frames = true;  // a record that ends in a step tells less
  d.carried_mass = 75.0 / 2.2046;
  EXPECT_EQ(find(judge_dynamics(d), "mass-carried")->weight, Weight::kRemark);
  d.by_platforms = false;
  EXPECT_EQ(find(judge_dynamics(d), "mass-carried")->weight, Weight::kUnusable);
  d.carried_mass = 68.0;
  EXPECT_EQ(find(judge_dynamics(d), "mass-carried"), nullptr);
}

TEST(JudgeDynamics, NamesCoordinatesThatTheMotionLacks) {
  DynamicsEvidence d = good_dynamics();
  d.not_given = {"shoulder"};
  const std::vector<VerdictReason> reasons = judge_dynamics(d);
  ASSERT_EQ(reasons.size(), 1u);
  EXPECT_EQ(reasons[0].code, "not-in-motion");
  EXPECT_EQ(reasons[0].torques, (Names{"shoulder"}));
}

TEST(JudgeModel, WeighsAPerson) {
  EXPECT_TRUE(judge_model({75.0, true, 1.75, {}}).empty());
  EXPECT_TRUE(judge_model({3.4, false, 0.6, {}}).empty());  // an arm
  expect_reason(judge_model({716.0, true, 1.75, {}}), "mass", Weight::kUnusable, 716.0, 300.0,
                "kg");
  // 165 lb taken for kg: 165 / 1.75² = 53.9.
  expect_reason(judge_model({165.0, true, 1.75, {}}), "body-mass-index", Weight::kRemark,
                165.0 / 3.0625, 45.0, "kg/m²");
  EXPECT_EQ(find(judge_model({190.0, true, 1.75, {}}), "body-mass-index")->weight,
            Weight::kUnusable);
  expect_reason(judge_model({34.0, true, 1.75, {}}), "body-mass-index", Weight::kRemark,
                34.0 / 3.0625, 12.0, "kg/m²");
  EXPECT_EQ(find(judge_model({30.0, true, 1.75, {}}), "body-mass-index")->weight,
            Weight::kUnusable);
  expect_reason(judge_model({120.0, true, 2.5, {}}), "height", Weight::kRemark, 2.5, 2.2, "m");
  EXPECT_EQ(find(judge_model({250.0, true, 3.5, {}}), "height")->weight, Weight::kUnusable);
}

TEST(JudgeModel, ComparesTheSides) {
  const ModelEvidence even{75.0, true, 1.75, {{"femur_r", "femur_l", 0.42, 0.41}}};
  EXPECT_TRUE(judge_model(even).empty());
  const ModelEvidence odd{
      75.0, true, 1.75, {{"talus_r", "talus_l", 0.05, 0.06}, {"femur_r", "femur_l", 0.4, 0.44}}};
  expect_reason(judge_model(odd), "side-size", Weight::kRemark, 10.0, 5.0, "%");
  EXPECT_NE(find(judge_model(odd), "side-size")->text.find("femur_r"), std::string::npos);
}

TEST(JudgeScale, HoldsSizesPoseAndMarkersAgainstPeople) {
  ScaleEvidence s;
  s.factors = {{"pelvis", 0.9, 1.2}, {"humerus_r", 0.49, 1.1}, {"torso", 0.9, 1.81}};
  s.pose_rms = 0.0335;
  s.moved = {{"A", 0.01}, {"B", 0.05}, {"C", 0.21}};
  const std::vector<VerdictReason> reasons = judge_scale(s);
  expect_reason(reasons, "marker-rms", Weight::kRemark, 33.5, 20.0, "mm");
  expect_reason(reasons, "scale-factor", Weight::kRemark, 1.81, 1.5, "times the model's");
  expect_reason(reasons, "moved-marker", Weight::kRemark, 210.0, 40.0, "mm");
  EXPECT_EQ(find(reasons, "moved-marker")->text.substr(0, 5), "C, B ");
  EXPECT_EQ(reasons.size(), 4u);  // humerus too
  s = {};
  EXPECT_TRUE(judge_scale(s).empty());
  s.factors = {{"pelvis", 1000.0, 1000.0}};
  s.converged = false;
  EXPECT_EQ(find(judge_scale(s), "scale-factor")->weight, Weight::kUnusable);
  EXPECT_EQ(find(judge_scale(s), "unconverged")->weight, Weight::kUnusable);
}

VerdictEvidence evidence_of_two_joints() {
  VerdictEvidence e;
  e.joints = {{"hip_right", {"hip_r"}}, {"hip_left", {"hip_l"}}, {"shoulder", {"shoulder"}}};
  e.angles = e.torques = true;
  e.model = {75.0, true, 1.75, {}};
  e.kinematics = good_kinematics();
  e.dynamics = good_dynamics();
  return e;
}

TEST(Judge, IsGoodWithoutReasons) {
  const Verdict verdict = judge(evidence_of_two_joints());
  EXPECT_EQ(verdict.level, Verdict::Level::kGood);
  EXPECT_TRUE(verdict.reasons.empty());
  for (const JointVerdict& j : verdict.joints) {
    EXPECT_EQ(j.angles, Use::kUsable);
    EXPECT_EQ(j.torques, Use::kUsable);
  }
  EXPECT_EQ(exit_code(verdict, false), 0);
}

TEST(Judge, TellsEachJointApart) {
  VerdictEvidence e = evidence_of_two_joints();
  e.dynamics->feet[0].complete = e.dynamics->known = 120;
  VerdictReason bare;
  bare.code = "segment-without-marker";
  bare.text = "one of the thighs has no marker";
  bare.angles = {"hip_l"};
  bare.torques = {"hip_l"};
  e.found = {bare, bare};
  const Verdict verdict = judge(e);
  EXPECT_EQ(verdict.level, Verdict::Level::kRemarks);
  EXPECT_EQ(verdict.reasons.size(), 2u);  // the same twice stands once
  EXPECT_EQ(verdict.joints, (std::vector<JointVerdict>{{"hip_right", Use::kUsable, Use::kPartly},
                                                       {"hip_left", Use::kUnusable, Use::kUnusable},
                                                       {"shoulder", Use::kUsable, Use::kUsable}}));
  EXPECT_EQ(exit_code(verdict, false), 0);
}

// A reason that names no coordinate spoils them all, but a wrong mass no angle.
TEST(Judge, BlamesEveryJointForWhatSpoilsTheTrial) {
  VerdictEvidence e = evidence_of_two_joints();
  VerdictReason other;
  other.code = "other-person";
  other.weight = Weight::kUnusable;
  e.found = {other};
  for (const JointVerdict& j : judge(e).joints) {
    EXPECT_EQ(j.angles, Use::kUnusable) << j.joint;
    EXPECT_EQ(j.torques, Use::kUnusable) << j.joint;
  }
  e.found[0].code = "mass-unit";
  for (const JointVerdict& j : judge(e).joints) {
    EXPECT_EQ(j.angles, Use::kUsable) << j.joint;
    EXPECT_EQ(j.torques, Use::kUnusable) << j.joint;
  }
  e.found[0].weight = Weight::kRemark;
  EXPECT_EQ(judge(e).joints[0].torques, Use::kUsable);
}

TEST(Judge, PutsWhatSpoilsAllFirstAndFails) {
  VerdictEvidence e = evidence_of_two_joints();
  e.kinematics->markers[0].max = 0.05;
  e.dynamics->root.force_rms = 5e6;
  const Verdict verdict = judge(e);
  EXPECT_EQ(verdict.level, Verdict::Level::kUnusable);
  EXPECT_EQ(verdict.reasons.front().code, "residual-force");
  EXPECT_EQ(verdict.joints[2].torques, Use::kUnusable);
  EXPECT_EQ(verdict.joints[2].angles, Use::kUsable);
  EXPECT_EQ(exit_code(verdict, false), 1);
  EXPECT_EQ(exit_code(verdict, true), 0);
}

TEST(Judge, LeavesACodeToWhoFoundIt) {
  VerdictEvidence e = evidence_of_two_joints();
  e.kinematics->filled = 0.5;
  VerdictReason found;
  found.code = "filled-share";
  found.text = "half of the positions of RKNE were filled in";
  e.found = {found};
  const Verdict verdict = judge(e);
  ASSERT_EQ(verdict.reasons.size(), 1u);
  EXPECT_EQ(verdict.reasons[0].text, found.text);
}

// An evidence left at its impossible values raises nothing and writes no NaN.
TEST(VerdictReport, IsFiniteSafe) {
  VerdictEvidence e;
  e.kinematics = KinematicsEvidence{};
  e.dynamics = DynamicsEvidence{};
  e.scale = ScaleEvidence{};
  VerdictReason strange;
  strange.code = "x";
  strange.text = "M\xe4rz";  // Latin-1, as old files have it
  e.found = {strange};
  const Verdict verdict = judge(e);
  ASSERT_EQ(verdict.reasons.size(), 1u);
  const nlohmann::ordered_json json = verdict_json(verdict);
  EXPECT_TRUE(json["reasons"][0]["figure"].is_null());
  EXPECT_TRUE(json["reasons"][0]["limit"].is_null());
  EXPECT_TRUE(root_json(*e.dynamics)["force_share"].is_null());
  EXPECT_EQ(root_text(*e.dynamics), "");
  EXPECT_NO_THROW(json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

TEST(VerdictReport, SaysWhatIsNormalAndWhatHelps) {
  VerdictEvidence e = evidence_of_two_joints();
  e.kinematics->marker_rms = 0.603;
  EXPECT_EQ(verdict_text(judge(e), 5),
            "verdict: not usable\n"
            "  - the model's markers are beside the measured ones (RMS of all): 603 mm (normal: at "
            "most 20 mm, Hicks et al. 2015); wrong unit, axes, model or names: `sinew check "
            "RECORDING --model MODEL` tells\n"
            "  not to be used: angles of hip_right, hip_left; torques of hip_right, hip_left\n");
}

TEST(VerdictReport, NeverGrowsBeyondItsLines) {
  VerdictEvidence e = evidence_of_two_joints();
  for (int i = 0; i < 30; ++i) {
    VerdictReason r;
    r.code = "r" + std::to_string(i);
    r.text = "reason";
    r.angles = {"hip_r"};
    e.found.push_back(r);
  }
  const Verdict verdict = judge(e);
  for (const int lines : {3, 4, 8, 12}) {
    const std::string text = verdict_text(verdict, lines);
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), lines) << text;
    EXPECT_NE(text.find("more: see the verdict's file"), std::string::npos);
    EXPECT_NE(text.find("angles of hip_right"), std::string::npos);
  }
}

TEST(VerdictReport, CountsWhatIsOfOneKind) {
  VerdictEvidence e = evidence_of_two_joints();
  const auto find = [&e](const char* code, const char* text, double figure, double limit,
                         const char* unit) {
    VerdictReason r;
    r.code = code;
    r.text = text;
    r.figure = figure;
    r.limit = limit;
    r.unit = unit;
    e.found.push_back(r);
  };
  for (const char* text : {"RTOE sits beside it", "RHEE sits beside it", "RANK sits beside it"}) {
    find("moved-marker", text, 50.0, 40.0, "mm");
    e.found.back().remedy = "look";
  }
  find("segment-without-marker", "both hands have no marker", 2.0, 0.0, "");
  find("loads-missing", "loads are known in a part only", 16.2, 100.0, "% of the frames");
  EXPECT_EQ(verdict_text(judge(e), 12),
            "verdict: usable with remarks\n"
            "  - RTOE sits beside it: 50 mm (normal: at most 40 mm), and 2 more like it; look\n"
            "  - both hands have no marker: 2 (normal: none)\n"
            "  - loads are known in a part only: 16.2 % of the frames (normal: 100 %)\n");
}

TEST(VerdictReport, StandsBesideItsOutput) {
  EXPECT_EQ(verdict_path("a/q.mot"), "a/q_verdict.json");
  EXPECT_EQ(verdict_path("id.sto"), "id_verdict.json");
}

}  // namespace
}  // namespace sinew
