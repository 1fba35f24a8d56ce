#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "data/marker_trajectories.h"
#include "data/verdict_reason.h"
#include "ik/cold_start.h"
#include "ik/minimizer_options.h"
#include "ik/size_limits.h"
#include "model/musculoskeletal_model.h"
#include "model/scaling.h"

namespace sinew {

/// A recording to fit a model to: a static trial or a movement.
struct AutoScaleTrial {
  const MarkerFile* recording = nullptr;
  std::optional<double> from, to;  // the part that is used [s]
};

/// What is known of people and markers before any is measured, and how the fit is done.
struct AutoScaleOptions {
  enum class Axes {
    kEach,     // three factors a body: x, y, z; the prior ties them as closely as people are alike
    kUniform,  // one
  };

  Axes axes = Axes::kEach;
  bool tie_sides = true;  // left and right bodies (`_l`, `_r`, …) share their factors
  // Further bodies that share their factors, by name. A body without markers shares them with the
  // only body that it carries, or else with the one that carries it.
  std::vector<std::vector<std::string>> groups;

  // Priors: standard deviations. The logarithm of a factor is the sum of three that are Gaussian
  // with mean zero: of the whole body's size, of the segment and of the axis.
  double size_sd = 0.15;  // between an adult of 1.5 m or 2.0 m and a model of 1.75 m
  double segment_sd =
      0.05;               // of a segment's length over stature (Drillis & Contini 1966 give 3-6 %)
  double axis_sd = 0.05;  // of breadth and depth over length, which differ as much again
  // Of a marker from where the model's author put it, along each axis [m]: what examiners differ by
  // on a landmark (Della Croce et al. 2005, Gait Posture 21:226-237: 6-25 mm).
  double marker_offset_sd = 0.01;
  // Markers that mark no landmark, by name, and how far they may be from where the model has them,
  // along each axis [m]: on wands and clusters, as long as a hand is broad.
  std::vector<std::string> technical_markers;
  double technical_marker_sd = 0.1;
  // Of a marker in one frame from where it sits on the bone, along each axis [m]: soft tissue.
  double marker_sd = 0.005;
  // Of a joint that the markers do not determine, from the model's default [rad]: vertebrae and
  // shoulder girdles that share a turn among many. Without it a spine buckles to make a trunk fit.
  double posture_sd = 0.05;
  // Soft tissue moves with the gait cycle, not at random: the frames of a trial together weigh no
  // more than this many independent ones, nor than it has poses that differ. A static trial has
  // one.
  double independent_frames = 10.0;
  // What people are at most; the fit stays within.
  SizeLimits limits;

  int frames = 40;                 // of a trial, spread over its movement; more tell little more
  int max_iterations = 100;        // of the outer loop
  double tolerance = 1e-6;         // it ends when no factor changes by more than this fraction …
  double offset_tolerance = 1e-7;  // … and no marker by more than this [m]

  bool name_unmatched = true;   // as BindingOptions'
  MinimizerOptions minimizer;   // of each frame's pose
  ColdStartOptions cold_start;  // of the first search for it
  int threads = 0;              // 0: all cores; results do not depend on it
  /// Called after every iteration of the outer loop; return false to stop.
  std::function<bool(int done, int total)> progress;

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// One factor: of the bodies that share it, along one axis or all.
struct ScaleEstimate {
  std::string name;         // of the first of the bodies, with `.x`, `.y`, `.z` where axes differ
  std::vector<int> bodies;  // indices
  int axis = -1;            // 0, 1, 2; −1: all
  double factor = kNaN;
  // Of the factor's logarithm, i.e. fractions: before measuring; after it; and what the prior would
  // leave open if all other factors were known.
  double prior_sd = kNaN, posterior_sd = kNaN, open_sd = kNaN;
  // The markers say it themselves: posterior_sd < open_sd / 2. Else it follows from the others.
  bool determinate = false;
  bool at_limit = false;  // options.limits hold it
};

/// Where a marker sits, other than the model's author put it.
struct MarkerOffset {
  int marker = -1;                                   // index
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // after scaling, in the body's axes [m]
  Eigen::Vector3d posterior_sd{kNaN, kNaN, kNaN};    // [m]
  bool at_limit = false;                             // options.limits hold it
};

/// How well the model meets one of the trials.
struct AutoScaleTrialFit {
  int frames = 0;
  double poses = kNaN;  // that differ, and so how many independent frames it counts as
  double rms = kNaN;    // of the markers in the frames used [m]
  // Of each marker of the model the mean, over these frames, of where it was measured less where it
  // is, in its body's axes: markers × 3 [m], NaN where it is not tracked.
  RowMatrix residuals;
};

struct AutoScaleResult {
  ScaleFactors factors;
  double size = kNaN;  // factor of the whole body, about which those of the segments vary
  std::vector<ScaleEstimate> estimates;
  std::vector<MarkerOffset> offsets;  // of the tracked markers that are not fixed
  std::vector<Marker> markers;        // of the model, scaled and moved
  double rms_before = kNaN;  // of the markers in the frames used, with the model as it was …
  double rms_scaled = kNaN;  // … with the factors, markers where the model has them …
  double rms_after = kNaN;   // … and with both [m]
  std::vector<AutoScaleTrialFit> trials;
  double cost = kNaN;  // −log of the posterior density, up to a constant
  int frames = 0, iterations = 0;
  bool converged = false, stopped = false;
  double seconds = kNaN;
  std::vector<Warning> warnings;
  std::vector<VerdictReason> reasons;  // `size-limit` and `moved-marker`: what limits hold

  explicit AutoScaleResult(const MusculoskeletalModel& model) : factors(model) {}
};

/// Fits the size of each segment, where each marker sits on it, and the pose of each frame to
/// recordings of a subject. With θ the logarithm of the body's size, those of the factors over it
/// and the offsets of the markers, and q_f the pose of frame f, it minimizes
///
///     F(θ) = w/2 Σ_f min_q ( Σ_m |p^d_fm − p_m(q, θ)|²/σ² + Σ_c (q_c − q0_c)²/s² ) + ½ θᵀ P⁻¹ θ
///
/// within lower ≤ θ ≤ upper (options.limits), where P is the covariance of the priors, σ =
/// marker_sd, s = posture_sd, c the joint angles that the markers leave open, and w the independent
/// frames of a trial over its frames. The poses are eliminated (variable projection; Golub &
/// Pereyra 1973, SIAM J Numer Anal 10:413-432): with J_q and J_θ the Jacobians of the markers of a
/// frame, its part of the curvature is J_θᵀ (E − J_q J_q⁺) J_θ, and its gradient, q being at the
/// minimum, J_θᵀ r. Each Gauss-Newton step is the minimum of its quadratic form within the limits,
/// halved until F falls. The inverse of the curvature is the posterior covariance. Markers that are
/// not measured drop out.
///
/// It starts from sizes that distances between markers tell, whatever the pose
/// (ik/distance_sizes.h), and from the poses of a model of these sizes, so that a subject of any
/// size may stand, sit or hold the arms as he likes. Where it ends, poses are looked for anew; if
/// any lies lower, it goes on.
///
/// Positions at a given pose are linear in the factors (scale_geometry()), so that J_θ is exact.
/// Throws InputError if no marker of the model is measured, std::invalid_argument for options out
/// of bounds or groups of unknown bodies. Time: per iteration, the poses of all frames, and
/// O(frames · markers · (θ² + unknowns²)).
AutoScaleResult auto_scale(const MusculoskeletalModel& model,
                           const std::vector<AutoScaleTrial>& trials,
                           const AutoScaleOptions& options = {});

}  // namespace sinew
