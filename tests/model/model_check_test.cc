#include "model/model_check.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "model/osim_file.h"
#include "model/whole_body.h"
#include "tests/model/leg_model.h"
#include "tests/model/shared_models.h"

namespace sinew {
namespace {

using Severity = ModelFinding::Severity;

std::vector<std::string> lines(const std::vector<ModelFinding>& findings) {
  std::vector<std::string> all;
  for (const ModelFinding& f : findings) {
    all.push_back(std::string(to_string(f.severity)) + ": " + f.kind + ": " + f.element + ": " +
                  f.text);
  }
  return all;
}

// What one change to a model without findings makes the check say.
template <typename Change>
std::vector<std::string> after(const Change& change) {
  MusculoskeletalModel model = leg_model();
  change(model);
  return lines(check_model(model));
}

using Lines = std::vector<std::string>;

PathElement& path(MusculoskeletalModel& model, const std::string& name) {
  return *std::find_if(model.paths.begin(), model.paths.end(),
                       [&](const PathElement& p) { return p.name == name; });
}

void expect_among(const Lines& found, const std::string& line) {
  EXPECT_EQ(std::count(found.begin(), found.end(), line), 1) << line << "\nis not among\n"
                                                             << ::testing::PrintToString(found);
}

PathPoint fixed_point(int body, const Eigen::Vector3d& p_BP) {
  PathPoint point;
  point.body = body;
  point.p_BP = p_BP;
  return point;
}

TEST(ModelCheck, FindsNothingInAModelWithoutMistakes) {
  EXPECT_EQ(after([](auto&) {}), Lines{});
}

TEST(ModelCheck, FindsLeftAndRightThatDiffer) {
  EXPECT_EQ(after([](auto& m) { m.bodies[m.find_body("tibia_r")].mass = 3.3; }),
            Lines{"warning: asymmetry: tibia_r: has 3.3 kg, 'tibia_l' 3 kg"});
  EXPECT_EQ(after([](auto& m) { m.bodies[m.find_body("tibia_l")].p_BCm.x() = 0.01; }),
            Lines{"warning: asymmetry: tibia_r: its mass centre and that of 'tibia_l' differ by "
                  "10.0 mm when mirrored"});
  EXPECT_EQ(after([](auto& m) { m.bodies[m.find_body("tibia_l")].I_BCm *= 1.1; }),
            Lines{"warning: asymmetry: tibia_r: its inertia and that of 'tibia_l' differ when "
                  "mirrored"});
  EXPECT_EQ(after([](auto& m) { m.joints[m.find_joint("femur_l_joint")].X_PF.p.z() = -0.12; }),
            Lines{"warning: asymmetry: femur_r_joint: its place and that of 'femur_l_joint' "
                  "differ by 20.0 mm when mirrored"});
  EXPECT_EQ(after([](auto& m) { path(m, "soleus_l").points[1].p_BP.z() = 0.002; }),
            Lines{"warning: asymmetry: soleus_r: its point 2 and that of 'soleus_l' differ by 2.0 "
                  "mm when mirrored"});
  expect_among(after([](auto& m) { path(m, "soleus_l").points[1].body = m.find_body("calcn_r"); }),
               "warning: asymmetry: soleus_r: its point 2 is on 'calcn_r', that of 'soleus_l' on "
               "'calcn_r'");
  EXPECT_EQ(after([](auto& m) { path(m, "soleus_l").max_isometric_force = 3600; }),
            Lines{"warning: asymmetry: soleus_r: maximum isometric force [N] 3500, of 'soleus_l' "
                  "3600"});
  EXPECT_EQ(after([](auto& m) { path(m, "soleus_l").name = "soleus_links_l"; }),
            (Lines{"warning: asymmetry: soleus_r: this path has no partner on the other side",
                   "warning: asymmetry: soleus_links_l: this path has no partner on the other "
                   "side"}));
  EXPECT_EQ(after([](auto& m) { m.markers[0].p_BM.y() = -0.35; }),
            Lines{"note: asymmetry: RKNE: its place and that of 'LKNE' differ by 50.0 mm when "
                  "mirrored"});
  expect_among(after([](auto& m) { m.markers[0].body = m.find_body("tibia_r"); }),
               "warning: asymmetry: RKNE: is on 'tibia_r', 'LKNE' on 'femur_l'");
}

TEST(ModelCheck, NamesPartners) {
  const auto first = [](const std::string& name) {
    const auto names = partner_names(name);
    return names.empty() ? std::string() : names[0];
  };
  EXPECT_EQ(first("femur_r"), "femur_l");
  EXPECT_EQ(first("femur_l"), "femur_r");
  EXPECT_EQ(first("R.ASIS"), "L.ASIS");
  EXPECT_EQ(first("LKNE"), "RKNE");
  EXPECT_EQ(first("soleus_medial_r_2"), "soleus_medial_l_2");
  EXPECT_EQ(first("torso"), "");
  EXPECT_EQ(first("radius"), "");
  EXPECT_EQ(first("Lumbar"), "");
}

// Forward instead of right: OpenSim's convention is not the only one.
TEST(ModelCheck, FindsTheMirrorOfTheModel) {
  MusculoskeletalModel model = leg_model();
  const auto swap = [](Eigen::Vector3d& p) { std::swap(p.x(), p.z()); };
  for (Joint& joint : model.joints) swap(joint.X_PF.p);
  for (Body& body : model.bodies) swap(body.p_BCm);
  for (Marker& marker : model.markers) swap(marker.p_BM);
  for (PathElement& each : model.paths) {
    for (PathPoint& point : each.points) swap(point.p_BP);
  }
  EXPECT_EQ(lines(check_symmetry(model, {})), Lines{});
}

TEST(ModelCheck, FindsPathsThroughNothing) {
  // Both sides alike, so that nothing but the mistake is told.
  const auto both = [](auto& m, const auto& change) {
    change(path(m, "flexor_r"));
    change(path(m, "flexor_l"));
  };
  expect_among(
      after([&](auto& m) { both(m, [](PathElement& p) { p.points.push_back(p.points.back()); }); }),
      "warning: path: flexor_r: its points 2 and 3 are at one place");
  expect_among(after([&](auto& m) {
                 both(m, [](PathElement& p) { p.points = {p.points[0], p.points[0]}; });
               }),
               "error: path: flexor_r: all its points are one");
  EXPECT_EQ(
      after([&](auto& m) { both(m, [](PathElement& p) { p.points[0].p_BP.y() = 0.33; }); })[0],
      "warning: natural length: flexor_r: its natural length 253.0 mm is shorter than the path in "
      "the "
      "default pose, 539.4 mm");
  expect_among(after([&](auto& m) {
                 both(m, [](PathElement& p) {
                   p.points[0].p_BP *= 5.0;
                   p.natural_length = 1.0;
                 });
               }),
               "warning: path: flexor_r: its point 1 is 640 mm from anything else on 'pelvis'");
  EXPECT_EQ(
      after([&](auto& m) {
        both(m, [](PathElement& p) { p.points[0] = fixed_point(p.points[1].body, {0, -0.05, 0}); });
      })[0],
      "warning: muscle: flexor_r: crosses no joint that moves: its length never changes");
}

TEST(ModelCheck, FindsMarkersFarFromTheirBone) {
  EXPECT_EQ(after([](auto& m) {
              m.markers[0].p_BM = {0, -0.2, 0.4};
              m.markers[2].p_BM = {0, -0.2, -0.4};
            }),
            (Lines{"warning: marker: RKNE: is 400 mm from anything else on 'femur_r'",
                   "warning: marker: LKNE: is 400 mm from anything else on 'femur_l'"}));
}

TEST(ModelCheck, FindsCoordinatesOutsideTheirRange) {
  EXPECT_EQ(after([](auto& m) {
              m.coordinates[0].default_value = 1.5;
              m.coordinates[0].clamped = true;
            }),
            Lines{"error: coordinate: tilt: its default 1.5 is outside its range -1 to 1, which it "
                  "is clamped to"});
  EXPECT_EQ(after([](auto& m) { m.coordinates[0].default_value = -1.5; }),
            Lines{"warning: coordinate: tilt: its default -1.5 is outside its range -1 to 1"});
  EXPECT_EQ(after([](auto& m) {
              m.coordinates[0].default_value = 1.5;
              m.coordinates[0].clamped = m.coordinates[0].locked = true;
            }),
            Lines{"warning: coordinate: tilt: its default 1.5 is outside its range -1 to 1"});
}

TEST(ModelCheck, FindsMassesThatNoBodyHas) {
  const auto both = [](auto& m, const char* bone, const auto& change) {
    for (const char* side : {"_r", "_l"}) change(m.bodies[m.find_body(std::string(bone) + side)]);
  };
  const auto massless = [](Body& body) {
    body.mass = 0.0;
    body.I_BCm.setZero();
  };
  expect_among(after([&](auto& m) { both(m, "calcn", massless); }),
               "warning: mass: calcn_r: has no mass, carries no body and is no virtual link");
  expect_among(after([&](auto& m) { both(m, "tibia", massless); }),
               "note: mass: tibia_r: has no mass; it carries other bodies");
  expect_among(after([&](auto& m) { both(m, "tibia", [](Body& body) { body.I_BCm.setZero(); }); }),
               "warning: mass: tibia_r: has 3 kg but no inertia");
  EXPECT_EQ(
      after([&](auto& m) { both(m, "tibia", [](Body& body) { body.I_BCm(1, 1) = 0.05; }); })[0],
      "error: mass: tibia_r: no body has its principal moments of inertia 0.02 0.02 0.05 kg "
      "m²: the largest exceeds the sum of the others");
}

void add_virtual_link(MusculoskeletalModel& model) {
  Body link;
  link.name = "fork";
  link.virtual_link = true;
  Joint joint;
  joint.name = "fork_joint";
  joint.kind = Joint::Kind::kFree;
  joint.parent = model.find_body("tibia_r");
  joint.child = static_cast<int>(model.bodies.size());
  joint.X_PF.p = {-0.03, -0.3, 0.0};
  for (int i = 0; i < 6; ++i) {
    Coordinate c;
    c.name = "fork" + std::to_string(i);
    c.joint = joint.child - 1;
    joint.coordinates.push_back(static_cast<int>(model.coordinates.size()));
    model.coordinates.push_back(c);
  }
  model.bodies.push_back(link);
  model.joints.push_back(joint);
}

void lead_to_fork(MusculoskeletalModel& model, const std::string& name, std::size_t end) {
  PathPoint& point = path(model, name).points[end];
  point.body = model.find_body("fork");
  point.p_BP.setZero();
}

// The link's own findings: moving points of one side makes asymmetries as well.
Lines of_fork(const MusculoskeletalModel& model) {
  Lines found;
  for (const std::string& line : lines(check_model(model))) {
    if (line.find("fork") != line.npos && line.find("asymmetry") == line.npos) {
      found.push_back(line);
    }
  }
  return found;
}

const char* const kTwoEnds =
    "note: virtual link: fork: only two ends of paths are on it: it neither forks nor joins";

TEST(ModelCheck, FindsVirtualLinksThatNothingHolds) {
  MusculoskeletalModel model = leg_model();
  add_virtual_link(model);
  EXPECT_EQ(of_fork(model), Lines{"error: virtual link: fork: no path ends on it: nothing holds "
                                  "it"});
  lead_to_fork(model, "soleus_r", 1);
  EXPECT_EQ(of_fork(model), Lines{"error: virtual link: fork: one path pull on it in one direction "
                                  "only (within 0.0 degrees): nothing holds it against them"});
  lead_to_fork(model, "gas_med_r", 0);
  EXPECT_EQ(of_fork(model), Lines{kTwoEnds});
  path(model, "gas_med_r").points[1] = fixed_point(model.find_body("tibia_r"), {0, -0.4, 0});
  EXPECT_EQ(of_fork(model), Lines{"warning: virtual link: fork: all its paths lead to 'tibia_r': "
                                  "it joins nothing"});
}

// The bone next to the link need not be the one that a path comes from.
TEST(ModelCheck, FollowsPathsPastTheirViaPoints) {
  MusculoskeletalModel model = leg_model();
  add_virtual_link(model);
  lead_to_fork(model, "soleus_r", 1);
  lead_to_fork(model, "gas_med_r", 0);
  PathElement& through = path(model, "gas_med_r");
  through.points.insert(through.points.begin() + 1,
                        fixed_point(model.find_body("tibia_r"), {0, -0.4, 0}));
  EXPECT_EQ(of_fork(model), Lines{kTwoEnds});
}

TEST(ModelCheck, FindsNothingInTheWholeBody) {
  for (const auto level :
       {WholeBodyOptions::Level::kSimplified, WholeBodyOptions::Level::kDetailed}) {
    for (const ModelFinding& finding : check_model(whole_body({.level = level}))) {
      ADD_FAILURE() << finding.element << ": " << finding.text;
    }
  }
}

TEST(ModelCheck, PassesOnWhatTheReaderWarnedOf) {
  EXPECT_EQ(after([](auto& m) {
              m.warnings.push_back({{"legs.osim", 7}, "something is odd"});
            }),
            Lines{"warning: reading: legs: something is odd"});
}

TEST(ModelCheck, PutsErrorsFirst) {
  const Lines found = after([](auto& m) {
    m.bodies[m.find_body("tibia_r")].mass = 3.3;
    m.coordinates[0].default_value = 1.5;
    m.coordinates[0].clamped = true;
    m.markers[0].p_BM.y() = -0.35;
  });
  ASSERT_EQ(found.size(), 3u);
  EXPECT_TRUE(found[0].starts_with("error: coordinate"));
  EXPECT_TRUE(found[1].starts_with("warning: asymmetry"));
  EXPECT_TRUE(found[2].starts_with("note: asymmetry"));
}

TEST(ModelCheck, RefusesTolerancesThatAreNone) {
  try {
    check_model(leg_model(), {.mirror_tolerance = 0.0});
    FAIL() << "no error";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "mirror_tolerance is 0; expected a number above 0");
  }
}

TEST(ModelCheck, FindsNoErrorInPublishedModels) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  for (const char* file : {"opensim-models/Gait2354_Simbody/gait2354_simbody.osim",
                           "nimblephysics/Arnold2013Synthetic/unscaled_generic.osim",
                           "opensim-models/Gait10dof18musc/gait10dof18musc.osim"}) {
    for (const ModelFinding& f : check_model(read_osim(kSharedData / file))) {
      EXPECT_NE(f.severity, Severity::kError) << file << " " << f.element << " " << f.text;
    }
  }
}

}  // namespace
}  // namespace sinew
