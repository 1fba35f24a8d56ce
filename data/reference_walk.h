#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

namespace sinew {

/// mean + Σ_k a_k cos 2πkφ + b_k sin 2πkφ, of the phase φ of a stride: periodic, with derivatives
/// of every order.
struct FourierSeries {
  double mean = 0.0;
  std::vector<double> cosines, sines;  // a_k, b_k for k = 1, 2, …

  bool operator==(const FourierSeries&) const = default;
};

/// Value, first and second derivative by φ. O(harmonics).
std::array<double, 3> evaluate(const FourierSeries& series, double phase);

/// How one coordinate of the model moves: series(φ − delay) + advance·φ, φ = time / stride time.
struct WalkCurve {
  std::string coordinate;
  FourierSeries series;  // [rad or m]
  double delay = 0.0;    // [strides]
  double advance = 0.0;  // [m per stride]
};

/// A foot on the floor y = 0. The sole touches from `strike` on for `stance`; its footprint is the
/// outline's place in the world while it lies flat, `stride_length` further with each stride.
struct WalkFoot {
  std::string body;      // that the floor pushes
  std::string side;      // "r" or "l": ground_force_r_vx, …
  double strike = 0.0;   // phase at which the stance begins [strides]
  double stance = 0.0;   // its duration [strides]
  Eigen::Vector3d p_WB;  // of the body's origin while it lies flat, in stride 0 [m]
  double toe_out = 0.0;  // heading while it lies flat, about −Y for the right foot [rad]
  std::vector<Eigen::Vector3d> outline;  // of the sole in the body's frame, a convex polygon [m]
  // Centre of pressure in the body's frame while it lies flat, from strike to toe-off, straight.
  Eigen::Vector3d first_pressure, last_pressure;
};

/// A walk as plain values: a curve for each coordinate that moves, and what each foot does on the
/// floor. X points forward, Y up, Z to the right.
struct ReferenceWalk {
  double stride_time = 0.0;    // [s]
  double stride_length = 0.0;  // [m]
  std::vector<WalkCurve> curves;
  std::vector<WalkFoot> feet;
};

/// The embedded default: the whole body's man of 75 kg and 1.80 m at 1.36 m/s. The left side is the
/// right side's mirror image, half a stride later; the trunk's turns are shared evenly by the
/// vertebrae about the navel, L5 to L2.
///
/// The curves are those typical of healthy men at their natural cadence (normative_curves())
/// fitted to this body by least squares over the coefficients of their Fourier series, so that
///  - each foot stays where it has stepped, heel, ball and tip in turn, and clears the floor after;
///  - the force that the motion asks of the floor has the two humps of a walk and acts where the
///    feet are, and the torques about hip, knee and ankle keep to their typical course: see
///    make_reference_recording.
/// The fit was made with the trunk as one body that turns about the navel.
ReferenceWalk reference_walk();

/// The vertebrae that share the trunk's turns, from the lowest up.
std::vector<std::string> turning_vertebrae();

/// Points of a typical curve over the stride, from a foot's strike on; the right foot's, or the
/// trunk's from the right foot's strike on.
struct NormativeCurve {
  // Of the model; of the right side where there are two. lumbar_extension, lumbar_bending and
  // lumbar_rotation are sums over turning_vertebrae().
  std::string coordinate;
  std::vector<double> percent;      // of the stride
  std::vector<double> degrees;      // in the model's sign
  double standard_deviation = 0.0;  // between men, typical [degrees]
};

/// Typical angles of healthy men, rounded to a degree: the common course of the curves in the works
/// below, not a digitization of any one of their figures or tables.
///  - Winter DA (2009) Biomechanics and Motor Control of Human Movement, 4th ed., Wiley: hip, knee
///    and ankle in the sagittal plane, natural cadence;
///  - Kadaba MP, Ramakrishnan HK, Wootten ME (1990) J Orthop Res 8:383-392: pelvis, hip in the
///    frontal and transverse plane;
///  - Perry J, Burnfield JM (2010) Gait Analysis, 2nd ed., Slack: trunk, subtalar joint;
///  - Murray MP, Sepic SB, Barnard EJ (1967) Phys Ther 47:272-284: shoulder and elbow.
std::vector<NormativeCurve> normative_curves();

}  // namespace sinew
