#include "model/scaling.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "model/kinematic_tree.h"
#include "model/path_length.h"

namespace sinew {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Factors within this of each other are one factor: Simbody's SignificantReal, which OpenSim uses.
const double kSameFactor = std::pow(std::numeric_limits<double>::epsilon(), 7.0 / 8.0);

bool same_factor(double a, double b) {
  return std::abs(a - b) <= kSameFactor * std::max({std::abs(a), std::abs(b), 1.0});
}

bool is_uniform(const Vector3d& f) { return same_factor(f[0], f[1]) && same_factor(f[1], f[2]); }

const Vector3d& factors_of(const ScaleFactors& factors, int body) {
  return factors.of_body[static_cast<std::size_t>(body)];
}

void grow(Vector3d& p, const Vector3d& f) { p = p.cwiseProduct(f); }

// Moments of a cylinder along `axis` whose radius squared and length are given, on the diagonal.
Vector3d cylinder_moments(double mass, double radius_squared, double length, int axis) {
  Vector3d moments = Vector3d::Constant(mass * (length * length / 12.0 + 0.25 * radius_squared));
  moments[axis] = 0.5 * mass * radius_squared;
  return moments;
}

Matrix3d scale_as_cylinder(const Matrix3d& I, double mass_before, double mass_after,
                           const Vector3d& f) {
  int axis = 0;
  I.diagonal().minCoeff(&axis);
  const int other = axis == 0 ? 1 : 0;
  const double radius_squared = std::max(0.0, 2.0 * I(axis, axis) / mass_before);
  const double length = std::sqrt(
      std::max(0.0, 12.0 * (I(other, other) - 0.25 * mass_before * radius_squared) / mass_before));
  const double across = f[(axis + 1) % 3] * f[(axis + 2) % 3];
  Matrix3d scaled = (mass_after / mass_before) * I.cwiseProduct(f * f.transpose());
  scaled.diagonal() = cylinder_moments(mass_after, radius_squared * across, length * f[axis], axis);
  return scaled;
}

void scale_joint(Joint& joint, const ScaleFactors& factors) {
  const Vector3d& parent = factors_of(factors, joint.parent);
  grow(joint.X_PF.p, parent);
  grow(joint.X_BM.p, factors_of(factors, joint.child));
  grow(joint.radii, parent);
  if (joint.kind != Joint::Kind::kCustom) return;
  for (std::size_t i = 3; i < 6; ++i) {
    joint.axes[i].function.scale *= translation_scale(joint.axes[i], parent);
  }
}

void scale_path_points(PathElement& path, const ScaleFactors& factors) {
  for (PathPoint& point : path.points) {
    const Vector3d& f = factors_of(factors, point.body);
    grow(point.p_BP, f);
    if (point.kind != PathPoint::Kind::kMoving) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      point.location[i].function.scale *= f[static_cast<Eigen::Index>(i)];
    }
  }
}

// A coupler that sets a shift gives metres: it grows as a shift along the same axis does.
void scale_couplers(MusculoskeletalModel& model, const ScaleFactors& factors) {
  for (CoordinateCoupler& coupler : model.couplers) {
    const Coordinate& dependent = model.coordinates[static_cast<std::size_t>(coupler.dependent)];
    if (dependent.motion != Coordinate::Motion::kTranslational) continue;
    const Joint& joint = model.joints[static_cast<std::size_t>(dependent.joint)];
    coupler.function.scale *=
        coupler_scale(joint, coupler.dependent, factors_of(factors, joint.parent));
  }
}

void scale_masses(MusculoskeletalModel& model, const ScaleFactors& factors,
                  const ScaleOptions& options) {
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    Body& body = model.bodies[b];
    const BodyInertia scaled = scale_inertia({body.mass, body.I_BCm}, factors.of_body[b],
                                             !options.preserve_mass_distribution);
    body.mass = scaled.mass;
    body.I_BCm = scaled.I_BCm;
  }
  if (!options.mass) return;
  const double ratio = mass_ratio(model.total_mass(), *options.mass, model.name);
  for (Body& body : model.bodies) {
    body.mass *= ratio;
    body.I_BCm *= ratio;
  }
}

void scale_lengths(PathElement& path, double ratio) {
  path.optimal_fiber_length *= ratio;
  path.tendon_slack_length *= ratio;
  path.natural_length = path.kind == PathElement::Kind::kMuscle ? muscle_natural_length(path)
                                                                : path.natural_length * ratio;
}

}  // namespace

void ScaleOptions::validate() const {
  if (mass && !(*mass > 0.0 && std::isfinite(*mass))) {
    throw std::invalid_argument(
        fmt::format("ScaleOptions.mass is {}; expected more than 0 kg", *mass));
  }
}

void validate(const ScaleFactors& factors, const MusculoskeletalModel& model) {
  if (factors.of_body.size() != model.bodies.size()) {
    throw std::invalid_argument(fmt::format("scale factors of {} bodies for a model of {}",
                                            factors.of_body.size(), model.bodies.size()));
  }
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Vector3d& f = factors.of_body[b];
    if (f.allFinite() && f.minCoeff() > 0.0) continue;
    throw std::invalid_argument(
        fmt::format("scale factors of body '{}' are {} {} {}; expected finite numbers above 0",
                    model.bodies[b].name, f[0], f[1], f[2]));
  }
}

BodyInertia scale_inertia(const BodyInertia& body, const Vector3d& factors,
                          bool mass_grows_with_volume) {
  BodyInertia scaled = body;
  const double volume = factors.prod();
  if (mass_grows_with_volume) scaled.mass *= volume;
  if (scaled.mass <= std::numeric_limits<double>::epsilon()) {
    scaled.I_BCm.setZero();
  } else if (is_uniform(factors)) {
    if (mass_grows_with_volume) scaled.I_BCm *= volume;
    scaled.I_BCm *= factors[0] * factors[0];
  } else {
    scaled.I_BCm = scale_as_cylinder(body.I_BCm, body.mass, scaled.mass, factors);
  }
  return scaled;
}

double translation_scale(const TransformAxis& axis, const Vector3d& factors) {
  const auto* linear = std::get_if<LinearFunction>(&axis.function.kind);
  if (linear != nullptr && *linear == LinearFunction{1.0, 0.0} && axis.function.scale == 1.0) {
    return 1.0;
  }
  return axis.axis.cwiseAbs().dot(factors);
}

double coupler_scale(const Joint& joint, int coordinate, const Vector3d& factors) {
  for (std::size_t i = 3; joint.kind == Joint::Kind::kCustom && i < 6; ++i) {
    if (joint.axes[i].coordinate == coordinate) return joint.axes[i].axis.cwiseAbs().dot(factors);
  }
  return is_uniform(factors) ? factors[0] : std::cbrt(factors.prod());
}

double mass_ratio(double mass, double subject_mass, const std::string& model_name) {
  if (mass > 0.0) return subject_mass / mass;
  throw InputError({model_name}, {"no body of the model has mass",
                                  "bodies with mass, to be scaled to the subject", "",
                                  "Leave the subject's mass out, or give the bodies mass."});
}

MusculoskeletalModel scale_geometry(const MusculoskeletalModel& model,
                                    const ScaleFactors& factors) {
  MusculoskeletalModel scaled = model;
  for (std::size_t b = 0; b < scaled.bodies.size(); ++b) {
    grow(scaled.bodies[b].p_BCm, factors.of_body[b]);
  }
  scale_couplers(scaled, factors);  // looks at the joints as they were
  for (Joint& joint : scaled.joints) scale_joint(joint, factors);
  for (WeldConstraint& weld : scaled.welds) {
    grow(weld.X_B1F1.p, factors_of(factors, weld.body1));
    grow(weld.X_B2F2.p, factors_of(factors, weld.body2));
  }
  for (PointConstraint& point : scaled.point_constraints) {
    grow(point.p_B1P1, factors_of(factors, point.body1));
    grow(point.p_B2P2, factors_of(factors, point.body2));
  }
  for (Marker& marker : scaled.markers) grow(marker.p_BM, factors_of(factors, marker.body));
  for (PathElement& path : scaled.paths) scale_path_points(path, factors);
  return scaled;
}

std::vector<double> default_path_lengths(const MusculoskeletalModel& model) {
  const KinematicTree tree = compile_tree(model);
  KinematicWorkspace workspace(tree);
  update_poses(tree, workspace);
  std::vector<double> lengths;
  for (const PathElement& path : model.paths) {
    lengths.push_back(path_length(path, tree, workspace));
  }
  return lengths;
}

MusculoskeletalModel scale_model(const MusculoskeletalModel& model, const ScaleFactors& factors,
                                 const ScaleOptions& options) {
  options.validate();
  validate(factors, model);
  MusculoskeletalModel scaled = scale_geometry(model, factors);
  scale_masses(scaled, factors, options);
  const std::vector<double> before = default_path_lengths(model);
  const std::vector<double> after = default_path_lengths(scaled);
  for (std::size_t i = 0; i < scaled.paths.size(); ++i) {
    if (before[i] > 0.0) scale_lengths(scaled.paths[i], after[i] / before[i]);
  }
  return scaled;
}

}  // namespace sinew
