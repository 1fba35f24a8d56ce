#include "model/whole_body_masses.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/model/shared_models.h"
#include "tests/model/whole_body_neutral.h"

namespace sinew {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Sex = WholeBodyOptions::Sex;

constexpr double kMassTolerance = 0.01;  // of mass, of length and of moment of inertia

struct SegmentFigures {
  const char* name;  // as in the file of the source
  double mass, length, centre, sagittal, transverse, longitudinal;
};

// De Leva 1996, table 4, men; the lengths of a man of 1.741 m [m].
constexpr SegmentFigures kMen[] = {
    {"Head", 0.0694, 0.2033, 0.5976, 0.362, 0.376, 0.312},
    {"Upper trunk", 0.1596, 0.1707, 0.2999, 0.716, 0.454, 0.659},
    {"Middle trunk", 0.1633, 0.2155, 0.4502, 0.482, 0.383, 0.468},
    {"Lower trunk", 0.1117, 0.1457, 0.6115, 0.615, 0.551, 0.587},
    {"Upper arm", 0.0271, 0.2817, 0.5772, 0.285, 0.269, 0.158},
    {"Forearm", 0.0162, 0.2689, 0.4574, 0.276, 0.265, 0.121},
    {"Hand", 0.0061, 0.0862, 0.7900, 0.628, 0.513, 0.401},
    {"Thigh", 0.1416, 0.4222, 0.4095, 0.329, 0.329, 0.149},
    {"Shank", 0.0433, 0.4340, 0.4395, 0.251, 0.246, 0.102},
    {"Foot", 0.0137, 0.2581, 0.4415, 0.257, 0.245, 0.124},
};

std::vector<std::string> bones_of(const std::string& segment) {
  const auto vertebrae = [](char region, int from, int to) {
    std::vector<std::string> names;
    for (int i = from; i <= to; ++i) names.push_back(region + std::to_string(i));
    return names;
  };
  const auto with = [](std::vector<std::string> list, const std::vector<std::string>& more) {
    list.insert(list.end(), more.begin(), more.end());
    return list;
  };
  if (segment == "Head") return with(vertebrae('C', 1, 7), {"skull"});
  if (segment == "Upper trunk") {
    return with(vertebrae('T', 1, 9), {"clavicle_r", "clavicle_l", "scapula_r", "scapula_l"});
  }
  if (segment == "Middle trunk") return with(vertebrae('T', 10, 12), vertebrae('L', 1, 4));
  if (segment == "Lower trunk") return {"pelvis", "L5"};
  if (segment == "Upper arm") return {"humerus_r"};
  if (segment == "Forearm") return {"ulna_r", "radius_r"};
  if (segment == "Thigh") return {"femur_r", "patella_r"};
  if (segment == "Shank") return {"tibia_r"};
  if (segment == "Foot") return {"calcn_r", "hallux_r", "toes_r"};
  std::vector<std::string> hand = {"hand_r", "metacarpal1_r", "thumb_proximal_r", "thumb_distal_r"};
  for (const char* finger : {"index", "middle", "ring", "little"}) {
    hand.push_back(std::string(finger) + "_proximal_r");
    hand.push_back(std::string(finger) + "_distal_r");
  }
  return hand;
}

struct Composite {
  double mass = 0.0;
  Vector3d centre = Vector3d::Zero();
  Matrix3d inertia = Matrix3d::Zero();
};

// Of some bodies, in the world, about their common mass centre.
Composite composite(const MusculoskeletalModel& model, const KinematicWorkspace& ws,
                    const std::vector<std::string>& bones) {
  Composite whole;
  for (const std::string& bone : bones) {
    const Body& body = model.bodies[static_cast<std::size_t>(model.find_body(bone))];
    whole.mass += body.mass;
    whole.centre += body.mass * (pose(model, ws, bone) * body.p_BCm);
  }
  whole.centre /= whole.mass;
  for (const std::string& bone : bones) {
    const Body& body = model.bodies[static_cast<std::size_t>(model.find_body(bone))];
    const RigidTransform X_WB = pose(model, ws, bone);
    const Matrix3d r = skew(X_WB * body.p_BCm - whole.centre);
    whole.inertia += X_WB.R * body.I_BCm * X_WB.R.transpose() - body.mass * r * r;
  }
  return whole;
}

// End points of a segment in the neutral pose: first end point, unit vector to the second, and the
// columns of the sagittal, transverse and longitudinal axes.
struct Ends {
  Vector3d first;
  Vector3d along;
  int sagittal, transverse, longitudinal;  // of X, Y, Z
};

Ends ends_of(const MusculoskeletalModel& model, const KinematicWorkspace& ws,
             const std::string& segment, double scale) {
  const auto at = [&](const char* body) { return pose(model, ws, body).p; };
  const Vector3d down = -Vector3d::UnitY();
  const auto above_hips = [&](double y) { return Vector3d(at("pelvis") + Vector3d(0.0, y, 0.0)); };
  if (segment == "Upper trunk") return {above_hips(0.5319 * scale), down, 0, 2, 1};
  if (segment == "Middle trunk") return {above_hips(0.3612 * scale), down, 0, 2, 1};
  if (segment == "Lower trunk") return {above_hips(0.1457 * scale), down, 0, 2, 1};
  if (segment == "Upper arm") return {at("humerus_r"), down, 0, 2, 1};
  if (segment == "Forearm") return {at("ulna_r"), down, 0, 2, 1};
  if (segment == "Hand") return {at("hand_r"), down, 2, 0, 1};  // palm to the thigh
  if (segment == "Thigh") return {at("femur_r"), down, 0, 2, 1};
  if (segment == "Shank") return {at("tibia_r"), down, 0, 2, 1};
  // The heel stands 60 mm behind the ankle, at 0.45 of the ankle's height of 70.2 mm.
  if (segment == "Foot") {
    return {at("calcn_r") + Vector3d(-0.060, -0.55 * 0.0702, 0.0), Vector3d::UnitX(), 1, 2, 0};
  }
  return {Vector3d(at("pelvis").x(), 1.80 - 0.0702, 0.0), down, 0, 2, 1};  // head; ankle at 0.0702
}

void expect_segment(const Neutral& body, const SegmentFigures& figures, double length,
                    double mass) {
  SCOPED_TRACE(figures.name);
  const Composite found = composite(body.model, body.ws, bones_of(figures.name));
  Ends ends = ends_of(body.model, body.ws, figures.name, 1.80 / 1.741);
  // The vertex is 1.80 m above the floor, the ankles 0.0702 m.
  if (std::string(figures.name) == "Head") {
    ends.first.y() += pose(body.model, body.ws, "calcn_r").p.y();
  }
  EXPECT_NEAR(found.mass, mass * figures.mass, 1e-3 * mass * figures.mass);
  const Vector3d centre = ends.first + figures.centre * length * ends.along;
  EXPECT_LE((found.centre - centre).norm(), kMassTolerance * figures.centre * length);
  const auto moment = [&](double radius) {
    return mass * figures.mass * std::pow(radius * length, 2);
  };
  const struct {
    int axis;
    double moment;
  } kMoments[] = {{ends.sagittal, moment(figures.sagittal)},
                  {ends.transverse, moment(figures.transverse)},
                  {ends.longitudinal, moment(figures.longitudinal)}};
  for (const auto& expected : kMoments) {
    EXPECT_NEAR(found.inertia(expected.axis, expected.axis), expected.moment,
                kMassTolerance * expected.moment);
    for (int other = 0; other < 3; ++other) {
      if (other == expected.axis) continue;
      EXPECT_LE(std::abs(found.inertia(expected.axis, other)), kMassTolerance * expected.moment);
    }
  }
}

TEST(WholeBody, HasTheSegmentsOfItsSource) {
  const Neutral body({});
  for (const SegmentFigures& figures : kMen) {
    expect_segment(body, figures, 1.80 / 1.741 * figures.length, 75.0);
  }
  EXPECT_NEAR(body.model.total_mass(), 75.0, 1e-12);
}

// The same, of men and women, from a published transcription of the tables.
TEST(WholeBody, HasTheSegmentsOfThePublishedFile) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  for (const Sex sex : {Sex::kMale, Sex::kFemale}) {
    const char* name = sex == Sex::kMale ? "BSPmale_ZdeLeva.txt" : "BSPfemale_ZdeLeva.txt";
    SCOPED_TRACE(name);
    std::ifstream file(kSharedData / "BMC/data" / name);
    ASSERT_TRUE(file.good());
    const Neutral body({.mass = 60.0, .sex = sex});
    int compared = 0;
    for (std::string line; std::getline(file, line);) {
      std::istringstream fields(line);
      std::string segment, ends;
      SegmentFigures figures{};
      std::getline(fields, segment, '\t');
      std::getline(fields, ends, '\t');
      fields >> figures.mass >> figures.centre >> figures.sagittal >> figures.transverse >>
          figures.longitudinal;
      for (const SegmentFigures& man : kMen) {
        // The foot's row is the only one of its name; the shank's other end points differ.
        if (segment != man.name || !fields) continue;
        figures.name = man.name;
        expect_segment(body, figures, 1.80 / 1.741 * man.length, 60.0);
        ++compared;
      }
    }
    EXPECT_EQ(compared, 10);
    EXPECT_NEAR(body.model.total_mass(), 60.0, 1e-12);
  }
}

}  // namespace
}  // namespace sinew
