#include "model/furcation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "model/kinematic_tree.h"
#include "model/model_check.h"
#include "model/osim_file.h"
#include "model/osim_writer.h"
#include "model/path_length.h"
#include "tests/model/leg_model.h"
#include "tests/model/same_model.h"
#include "tests/model/shared_models.h"

namespace sinew {
namespace {

using Names = std::vector<std::string>;

const PathElement& path(const MusculoskeletalModel& model, const std::string& name) {
  return *std::find_if(model.paths.begin(), model.paths.end(),
                       [&](const PathElement& p) { return p.name == name; });
}

std::map<std::string, double> default_lengths(const MusculoskeletalModel& model) {
  const KinematicTree tree = compile_tree(model);
  KinematicWorkspace workspace(tree);
  update_poses(tree, workspace);
  std::map<std::string, double> lengths;
  for (const PathElement& p : model.paths) lengths[p.name] = path_length(p, tree, workspace);
  return lengths;
}

// Muscle and tendon together are as long as the muscle was, and so are their natural lengths.
void expect_lengths_kept(const MusculoskeletalModel& before, const FurcatedModel& after) {
  constexpr double kRounding = 1e-12;  // [m]
  const auto was = default_lengths(before), is = default_lengths(after.model);
  std::map<std::string, double> tendon_of, natural_of;
  for (const Furcation& f : after.furcations) {
    EXPECT_NEAR(is.at(f.tendon), f.tendon_length, kRounding) << f.tendon;
    EXPECT_EQ(path(after.model, f.tendon).natural_length, f.tendon_length);
    for (const std::string& muscle : f.muscles) tendon_of[muscle] += f.tendon_length;
  }
  for (const PathElement& p : before.paths) {
    const double tendon = tendon_of.contains(p.name) ? tendon_of.at(p.name) : 0.0;
    const PathElement& changed = path(after.model, p.name);
    EXPECT_NEAR(is.at(p.name) + tendon, was.at(p.name), kRounding) << p.name;
    EXPECT_NEAR(changed.natural_length + tendon, p.natural_length, kRounding) << p.name;
    EXPECT_NEAR(changed.tendon_slack_length + tendon, p.tendon_slack_length, kRounding) << p.name;
    EXPECT_GT(changed.tendon_slack_length, 0.0) << p.name;
    EXPECT_GE(changed.points.size(), 2u);
  }
}

TEST(Furcation, JoinsMusclesThatInsertAtOnePlace) {
  const MusculoskeletalModel before = leg_model();
  const FurcatedModel after = furcate(before);
  ASSERT_EQ(after.furcations.size(), 2u);
  EXPECT_TRUE(after.warnings.empty());
  const Furcation& right = after.furcations[0];
  EXPECT_EQ(right.virtual_link, "furcation_calcn_r_1");
  EXPECT_EQ(right.tendon, "furcation_calcn_r_1_tendon");
  EXPECT_EQ(right.bone, "calcn_r");
  EXPECT_EQ(right.muscles, (Names{"gas_med_r", "gas_lat_r", "soleus_r"}));
  EXPECT_TRUE(right.insertion);
  EXPECT_NEAR(right.spread, 0.004, 1e-15);
  // Two fifths of the soleus' tendon, 0.8 · 0.33 m; of the free path it would be more.
  EXPECT_NEAR(right.tendon_length, 0.4 * 0.8 * 0.33, 1e-15);
  EXPECT_EQ(after.furcations[1].virtual_link, "furcation_calcn_l_1");
  EXPECT_EQ(after.model.virtual_link_count(), 2);
  EXPECT_EQ(after.model.coordinates.size(), before.coordinates.size() + 12);
  EXPECT_EQ(after.model.paths.size(), before.paths.size() + 2);
  expect_lengths_kept(before, after);
}

// The soleus is the strongest: the link lies on its line, the tendon ends where it did.
TEST(Furcation, PutsTheLinkOnTheStrongestMuscle) {
  const MusculoskeletalModel before = leg_model();
  const MusculoskeletalModel after = furcate(before).model;
  const Eigen::Vector3d origin(-0.02, -0.1, 0), heel(-0.05, -0.432, 0);  // in the shank
  const double length = 0.4 * 0.8 * 0.33;
  const Joint& joint = after.joints[after.find_joint("furcation_calcn_r_1_joint")];
  // Two gastrocnemii come from the femur, the soleus from the tibia, the tendon from the calcaneus.
  EXPECT_EQ(after.bodies[static_cast<std::size_t>(joint.parent)].name, "femur_r");
  const Eigen::Vector3d expected = heel + length * (origin - heel).normalized();
  EXPECT_LT((joint.X_PF.p - Eigen::Vector3d(0, -0.4, 0) - expected).norm(), 1e-15);
  const PathElement& tendon = path(after, "furcation_calcn_r_1_tendon");
  EXPECT_EQ(tendon.kind, PathElement::Kind::kTendon);
  ASSERT_EQ(tendon.points.size(), 2u);
  EXPECT_EQ(tendon.points[0].p_BP, Eigen::Vector3d::Zero());
  EXPECT_EQ(tendon.points[1].p_BP, path(before, "soleus_r").points[1].p_BP);
  EXPECT_LT(path(after, "soleus_r").points[1].p_BP.norm(), 1e-15);
}

// Via points on the bone go with the tendon.
TEST(Furcation, LeavesTheCourseOnTheBoneToTheTendon) {
  MusculoskeletalModel before = leg_model();
  for (PathElement& p : before.paths) {
    if (!p.name.starts_with("soleus") && !p.name.starts_with("gas")) continue;
    PathPoint via = p.points[1];
    via.p_BP += Eigen::Vector3d(-0.01, 0.02, 0.0);
    p.points.insert(p.points.begin() + 1, via);
  }
  const FurcatedModel after = furcate(before);
  ASSERT_EQ(after.furcations.size(), 2u);
  EXPECT_EQ(path(after.model, "furcation_calcn_r_1_tendon").points.size(), 3u);
  EXPECT_EQ(path(after.model, "gas_med_r").points.size(), 2u);
  expect_lengths_kept(before, after);
}

TEST(Furcation, JoinsOriginsToo) {
  MusculoskeletalModel before = leg_model();
  for (PathElement& p : before.paths) std::reverse(p.points.begin(), p.points.end());
  const FurcatedModel after = furcate(before);
  ASSERT_EQ(after.furcations.size(), 2u);
  EXPECT_FALSE(after.furcations[0].insertion);
  EXPECT_EQ(after.furcations[0].muscles, (Names{"gas_med_r", "gas_lat_r", "soleus_r"}));
  const PathElement& tendon = path(after.model, "furcation_calcn_r_1_tendon");
  EXPECT_EQ(tendon.points[0].body, after.model.find_body("calcn_r"));
  expect_lengths_kept(before, after);
}

TEST(Furcation, GroupsOnlyWhatIsWithinTheDistance) {
  EXPECT_EQ(furcate(leg_model(), {.distance = 0.001}).furcations.size(), 0u);
  // The soleus is 2.8 mm from either head of the gastrocnemius, these are 4 mm apart: it joins the
  // first.
  const FurcatedModel narrow = furcate(leg_model(), {.distance = 0.003});
  ASSERT_EQ(narrow.furcations.size(), 2u);
  EXPECT_EQ(narrow.furcations[0].muscles, (Names{"gas_med_r", "soleus_r"}));
}

TEST(Furcation, FurcatesWhatIsAskedForUnderItsName) {
  const MusculoskeletalModel before = leg_model();
  const FurcatedModel after = furcate(
      before,
      {.requests = {{{"gas_lat_l", "gas_med_l"}, "achilles_l"}, {{"gas_lat_r", "soleus_r"}, ""}}});
  ASSERT_EQ(after.furcations.size(), 2u);
  EXPECT_EQ(after.furcations[0].virtual_link, "achilles_l");
  EXPECT_EQ(after.furcations[0].tendon, "achilles_l_tendon");
  EXPECT_EQ(after.furcations[0].muscles, (Names{"gas_lat_l", "gas_med_l"}));
  EXPECT_EQ(after.furcations[1].virtual_link, "furcation_calcn_r_1");
  expect_lengths_kept(before, after);
}

TEST(Furcation, LeavesMusclesWithoutTendonAloneAndSaysSo) {
  MusculoskeletalModel before = leg_model();
  for (PathElement& p : before.paths) {
    if (p.name == "soleus_r") p.tendon_slack_length = 0.01;
  }
  const FurcatedModel after = furcate(before);
  ASSERT_EQ(after.furcations.size(), 1u);
  EXPECT_EQ(after.furcations[0].bone, "calcn_l");
  ASSERT_EQ(after.warnings.size(), 1u);
  EXPECT_EQ(after.warnings[0].text,
            "gas_med_r, gas_lat_r, soleus_r are left as they are on 'calcn_r': the tendon that "
            "they could share is 4.0 mm, and 5.0 mm are needed to leave the bone");
}

template <typename Error>
std::string error_of(const FurcationOptions& options) {
  MusculoskeletalModel model = leg_model();
  for (PathElement& p : model.paths) {
    if (p.name == "flexor_l") p.tendon_slack_length = 0.01;
    if (p.name == "flexor_l") p.points[1] = p.points[0];
    if (p.name == "gas_lat_l") p.tendon_slack_length = 0.01;
  }
  try {
    furcate(model, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Furcation, RefusesWhatCannotBeFurcated) {
  const auto request = [](const Names& muscles, const std::string& name = "") {
    return error_of<InputError>({.requests = {{muscles, name}}});
  };
  EXPECT_EQ(request({"soleus_r", "plantaris_r"}),
            "legs: has no muscle 'plantaris_r' to furcate; expected names of its muscles. See "
            "`sinew model info --moment-arms`.");
  EXPECT_EQ(request({"soleus_r", "soleus_l"}),
            "legs: soleus_r, soleus_l do not end on one bone; expected muscles with a bone in "
            "common at one of their ends. Leave some of them out.");
  EXPECT_EQ(request({"flexor_l", "soleus_l"}),
            "legs: 'flexor_l' cannot be furcated; expected a muscle with a tendon_slack_length and "
            "a path over a joint. Leave it out.");
  EXPECT_EQ(request({"gas_lat_l", "soleus_l"}),
            "legs: gas_lat_l, soleus_l have too little tendon in common; expected 0.0050 m, to "
            "leave the bone, found 0.0040 m. Leave the one with the least tendon out.");
  EXPECT_EQ(request({"gas_lat_r", "soleus_r"}, "tibia_r"),
            "legs: the name 'tibia_r' is taken by another body; expected a new name. Choose "
            "another name.");
  EXPECT_EQ(
      error_of<InputError>({.distance = 0.001, .requests = {{{"gas_lat_r", "soleus_r"}, ""}}}),
      "legs: the ends of gas_lat_r, soleus_r are too far apart; expected 0.001 m or less, "
      "found 0.0028 m. Allow a larger distance, or leave some of them out.");
}

TEST(Furcation, RefusesOptionsOutOfBounds) {
  using Bad = std::invalid_argument;
  EXPECT_EQ(error_of<Bad>({.distance = -1.0}), "distance is -1; expected a length, 0 or more");
  EXPECT_EQ(error_of<Bad>({.tendon_part = 0.5}),
            "tendon_part is 0.5; expected a part above 0 and below 0.5");
  EXPECT_EQ(error_of<Bad>({.shortest_tendon = 0.0}),
            "shortest_tendon is 0; expected a length above 0");
  EXPECT_EQ(error_of<Bad>({.requests = {{{"soleus_r"}, ""}}}),
            "'soleus_r' is no furcation; expected two or more different muscles");
  EXPECT_EQ(error_of<Bad>({.requests = {{{"soleus_r", "soleus_r"}, ""}}}),
            "'soleus_r, soleus_r' is no furcation; expected two or more different muscles");
}

Names groups_of(const FurcatedModel& after) {
  Names groups;
  for (const Furcation& f : after.furcations) {
    std::string group = f.bone + ":";
    for (const std::string& muscle : f.muscles) group += " " + muscle;
    groups.push_back(group);
  }
  return groups;
}

// The gastrocnemius and soleus are the Achilles tendon's, rectus and vastus the patella's, whose
// place is a moving point.
TEST(Furcation, FindsTheTendonsOfGait2354) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  const MusculoskeletalModel before =
      read_osim(kSharedData / "opensim-models/Gait2354_Simbody/gait2354_simbody.osim");
  const FurcatedModel after = furcate(before);
  const Names groups = groups_of(after);
  for (const char* side : {"_r", "_l"}) {
    const std::string s = side;
    EXPECT_EQ(
        std::count(groups.begin(), groups.end(), "calcn" + s + ": med_gas" + s + " soleus" + s), 1);
    EXPECT_EQ(
        std::count(groups.begin(), groups.end(), "tibia" + s + ": rect_fem" + s + " vas_int" + s),
        1);
  }
  expect_lengths_kept(before, after);
  const MusculoskeletalModel again = parse_osim("written.osim", write_osim(after.model));
  EXPECT_EQ(again.virtual_link_count(), static_cast<int>(after.furcations.size()));
  for (const ModelFinding& f : check_model(again)) {
    EXPECT_FALSE(f.kind == "virtual link" || f.severity == ModelFinding::Severity::kError)
        << f.element << ": " << f.text;
  }
}

}  // namespace
}  // namespace sinew
