#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "model/musculoskeletal_model.h"

namespace sinew {

/// How much longer each body of the subject is than the model's, along the body's own axes.
struct ScaleFactors {
  std::vector<Eigen::Vector3d> of_body;  // as MusculoskeletalModel::bodies, ground first; > 0

  /// All ones.
  explicit ScaleFactors(const MusculoskeletalModel& model)
      : of_body(model.bodies.size(), Eigen::Vector3d::Ones()) {}
  bool operator==(const ScaleFactors&) const = default;
};

struct ScaleOptions {
  // The subject's mass: that of all bodies together afterwards [kg]. Empty: what scaling gives.
  std::optional<double> mass;
  // Bodies keep their shares of the whole mass; else a body's mass grows with its volume first.
  bool preserve_mass_distribution = false;

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// Mass and inertia of one body.
struct BodyInertia {
  double mass = 0.0;                                // [kg]
  Eigen::Matrix3d I_BCm = Eigen::Matrix3d::Zero();  // about the mass centre, in B [kg m²]
};

/// Mass and inertia of a body that grows by `factors`, as OpenSim has it. Uniform factors s scale
/// the inertia by s², and by s³ if the mass grows with the volume. Else the body is taken for a
/// cylinder along the axis of its least moment, whose radius r and length l follow from its moments
/// ½mr² and m(l²/12 + r²/4); it is scaled, and products of inertia by their two factors.
BodyInertia scale_inertia(const BodyInertia& body, const Eigen::Vector3d& factors,
                          bool mass_grows_with_volume);

/// The factor of a shift along `axis` in a frame on a body that grows by `factors`: Σ |axis_i| f_i.
/// A shift that is the joint's own freedom, a coordinate one to one, has factor 1: it is measured
/// in metres of the world, not of the body.
double translation_scale(const TransformAxis& axis, const Eigen::Vector3d& factors);

/// The same for a coupler that sets coordinate `coordinate` of `joint`, a shift: along its axis in
/// a custom joint, else the mean factor.
double coupler_scale(const Joint& joint, int coordinate, const Eigen::Vector3d& factors);

/// subject_mass / mass. Throws InputError naming the model if that has no mass.
double mass_ratio(double mass, double subject_mass, const std::string& model_name);

/// Places of everything that is fixed on bodies, scaled by their body's factors: joint frames,
/// mass centres, markers, points of paths and of constraints; functions that shift a custom joint
/// by its parent's factors; radii of ellipsoid joints; couplers of translations. Masses, inertias
/// and muscle parameters stay. Positions at given coordinates are linear in the factors.
/// O(size of the model).
MusculoskeletalModel scale_geometry(const MusculoskeletalModel& model, const ScaleFactors& factors);

/// The model fitted to a subject by OpenSim's rules (ModelScaler of OpenSim 4): scale_geometry();
/// then inertias, see scale_inertia(), and masses; then optimal fibre and tendon slack lengths and
/// the natural lengths of tendons and ligaments by the growth of their path in the default pose.
/// Virtual links have no mass and stay so.
///
/// Differs from OpenSim where that would tear a model apart: points of a PointConstraint and
/// moving points without a coordinate are scaled too, couplers of translations also by factors that
/// differ between axes, and the lengths of paths are those of the straight pieces between points.
///
/// Throws std::invalid_argument if factors or options are not for this model, InputError if the
/// subject has mass and the model none. `model` must have passed validate().
MusculoskeletalModel scale_model(const MusculoskeletalModel& model, const ScaleFactors& factors,
                                 const ScaleOptions& options = {});

/// Lengths of all paths in the default pose [m].
std::vector<double> default_path_lengths(const MusculoskeletalModel& model);

/// Throws std::invalid_argument, naming the body, unless there is a finite factor above zero for
/// every axis of every body.
void validate(const ScaleFactors& factors, const MusculoskeletalModel& model);

}  // namespace sinew
