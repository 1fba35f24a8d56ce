#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "model/musculoskeletal_model.h"

/// Equality of descriptions, field by field, all but where they came from and what reading them
/// warned of.
namespace sinew {

inline bool same_number(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

// A rotation goes through three angles and back.
constexpr double kSameRotation = 1e-15 * 10;

inline void expect_same(const RigidTransform& a, const RigidTransform& b) {
  EXPECT_EQ(a.p, b.p);
  EXPECT_LT((a.R - b.R).cwiseAbs().maxCoeff(), kSameRotation);
}

inline void expect_same(const Body& a, const Body& b) {
  SCOPED_TRACE(a.name);
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.mass, b.mass);
  EXPECT_EQ(a.p_BCm, b.p_BCm);
  EXPECT_LE((a.I_BCm - b.I_BCm).norm(), 1e-15 * a.I_BCm.norm());  // made physical when read
  EXPECT_EQ(a.virtual_link, b.virtual_link);
}

inline void expect_same(const Coordinate& a, const Coordinate& b) {
  SCOPED_TRACE(a.name);
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.joint, b.joint);
  EXPECT_EQ(a.motion, b.motion);
  EXPECT_EQ(a.default_value, b.default_value);
  EXPECT_EQ(a.default_speed, b.default_speed);
  EXPECT_EQ(a.range_min, b.range_min);
  EXPECT_EQ(a.range_max, b.range_max);
  EXPECT_EQ(a.clamped, b.clamped);
  EXPECT_EQ(a.locked, b.locked);
  EXPECT_EQ(a.prescribed, b.prescribed);
}

inline void expect_same(const Joint& a, const Joint& b) {
  SCOPED_TRACE(a.name);
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.parent, b.parent);
  EXPECT_EQ(a.child, b.child);
  expect_same(a.X_PF, b.X_PF);
  expect_same(a.X_BM, b.X_BM);
  EXPECT_EQ(a.coordinates, b.coordinates);
  if (a.kind == Joint::Kind::kEllipsoid) {
    EXPECT_EQ(a.radii, b.radii);
  }
  if (a.kind != Joint::Kind::kCustom) return;
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(a.axes[i].axis, b.axes[i].axis);
    EXPECT_EQ(a.axes[i].coordinate, b.axes[i].coordinate);
    EXPECT_EQ(a.axes[i].function, b.axes[i].function);
  }
}

inline void expect_same(const CoordinateCoupler& a, const CoordinateCoupler& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.dependent, b.dependent);
  EXPECT_EQ(a.independent, b.independent);
  EXPECT_EQ(a.function, b.function);
}

inline void expect_same(const WeldConstraint& a, const WeldConstraint& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.body1, b.body1);
  EXPECT_EQ(a.body2, b.body2);
  expect_same(a.X_B1F1, b.X_B1F1);
  expect_same(a.X_B2F2, b.X_B2F2);
}

inline void expect_same(const PointConstraint& a, const PointConstraint& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.body1, b.body1);
  EXPECT_EQ(a.body2, b.body2);
  EXPECT_EQ(a.p_B1P1, b.p_B1P1);
  EXPECT_EQ(a.p_B2P2, b.p_B2P2);
}

inline void expect_same(const Marker& a, const Marker& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.body, b.body);
  EXPECT_EQ(a.p_BM, b.p_BM);
  EXPECT_EQ(a.fixed, b.fixed);
}

inline void expect_same(const PathPoint& a, const PathPoint& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.body, b.body);
  EXPECT_EQ(a.p_BP, b.p_BP);
  EXPECT_EQ(a.condition_coordinate, b.condition_coordinate);
  EXPECT_TRUE(same_number(a.condition_min, b.condition_min));
  EXPECT_TRUE(same_number(a.condition_max, b.condition_max));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(a.location[i].coordinate, b.location[i].coordinate);
    EXPECT_EQ(a.location[i].function, b.location[i].function);
  }
}

inline void expect_same(const PathElement& a, const PathElement& b) {
  SCOPED_TRACE(a.name);
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.class_name, b.class_name);
  EXPECT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < std::min(a.points.size(), b.points.size()); ++i) {
    expect_same(a.points[i], b.points[i]);
  }
  EXPECT_TRUE(same_number(a.max_isometric_force, b.max_isometric_force));
  EXPECT_TRUE(same_number(a.optimal_fiber_length, b.optimal_fiber_length));
  EXPECT_TRUE(same_number(a.tendon_slack_length, b.tendon_slack_length));
  EXPECT_TRUE(same_number(a.pennation_angle, b.pennation_angle));
  EXPECT_TRUE(same_number(a.natural_length, b.natural_length));
  EXPECT_TRUE(same_number(a.stiffness, b.stiffness));
  EXPECT_TRUE(same_number(a.dissipation, b.dissipation));
  EXPECT_TRUE(same_number(a.pcsa_force, b.pcsa_force));
}

template <typename Item>
void expect_same(const std::vector<Item>& a, const std::vector<Item>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) expect_same(a[i], b[i]);
}

inline void expect_same(const MusculoskeletalModel& a, const MusculoskeletalModel& b) {
  EXPECT_EQ(a.gravity, b.gravity);
  expect_same(a.bodies, b.bodies);
  expect_same(a.joints, b.joints);
  expect_same(a.coordinates, b.coordinates);
  expect_same(a.couplers, b.couplers);
  expect_same(a.welds, b.welds);
  expect_same(a.point_constraints, b.point_constraints);
  expect_same(a.markers, b.markers);
  expect_same(a.paths, b.paths);
}

}  // namespace sinew
