#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "data/c3d_file.h"
#include "data/numbers.h"

namespace sinew {

/// Symbols: W the laboratory, P a platform's axes, C the centre of its working surface. The axes of
/// P follow from the corners, which stand in its quadrants (+x,+y), (-x,+y), (-x,-y), (+x,-y); its
/// z points into the ground. Channels hold the reaction of the ground on the subject, in P.
struct ForcePlatform {
  int number = 0;                          // from 1
  int type = 0;                            // FORCE_PLATFORM:TYPE, 1 to 7
  std::array<Eigen::Vector3d, 4> corners;  // in W [m]
  Eigen::Vector3d p_WC;
  Eigen::Matrix3d R_WP;
  // From where forces make no moment to C, in P [m]; types 3, 6 and 7: half the distances of the
  // transducers along x and y, and z.
  Eigen::Vector3d origin;
  std::vector<int> channels;    // columns of C3dAnalog::values
  std::vector<double> to_si;    // what makes N, N·m or m of each channel's unit
  Eigen::MatrixXd calibration;  // types 4 to 7: makes N and N·m of channels, see compute_wrench
  std::string problem;          // why it cannot be used; empty if it can
  bool has_moments = true;      // false: forces only, for a lack of distances

  bool usable() const { return problem.empty(); }
};

struct ForcePlatformOptions {
  // Below this force along the platform's normal there is no centre of pressure [N]. 20 N is what
  // gait laboratories use: noise of 2 N moves the centre by less than a tenth of the platform.
  double threshold = kContactForce;
  // Subtract the mean over the frames that FORCE_PLATFORM:ZERO names, if the platform is not loaded
  // then.
  bool subtract_baseline = true;
  // Turn round forces that push the subject down, and correct moments by a factor of 1000 where
  // only that puts the centre of pressure onto the platform.
  bool correct = true;

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// What a platform measured, at the rate of the analog channels. In W, NaN where unknown.
struct ForcePlatformRecording {
  ForcePlatform platform;
  double rate = 0.0;      // [Hz]
  RowMatrix force;        // samples × 3, on the subject [N]
  RowMatrix moment;       // samples × 3, on the subject about C [N·m]
  RowMatrix center;       // samples × 3, centre of pressure [m]; NaN below the threshold
  RowMatrix free_moment;  // samples × 3, about the platform's normal there [N·m]; as `center`

  int sample_count() const { return static_cast<int>(force.rows()); }
};

struct ForcePlatforms {
  std::vector<ForcePlatformRecording> recordings;  // one a platform; unusable: no samples
  std::vector<Warning> warnings;
};

/// The platforms that the group FORCE_PLATFORM describes, SI. What cannot be used says so in
/// `problem`; what was corrected is in `warnings`.
std::vector<ForcePlatform> find_force_platforms(const C3dFile& file,
                                                std::vector<Warning>& warnings);

/// Force and moment about C of one sample, in P, from the platform's channels as they are stored.
/// O(1). Equations from the C3D User Guide (Motion Lab Systems), chapter FORCE_PLATFORM:TYPE; types
/// 5 to 7, which it does not have, as Visual3D's manual defines them, chapter FP_TYPE:
///   types 2, 4, 5  M_C = M_O + F × p_OC                                                      (1)
///   types 3, 7     F = (fx12 + fx34, fy14 + fy23, fz1 + fz2 + fz3 + fz4)                     (2)
///                  M_O = (b (fz1 + fz2 - fz3 - fz4), a (-fz1 + fz2 + fz3 - fz4),
///                         b (-fx12 + fx34) + a (fy14 - fy23))
///   type 1         M_C = p_CQ × F + (0, 0, Mz), Q the centre of pressure                     (3)
///   type 6         (2) with fx12 = fx1 + fx2, fx34 = fx3 + fx4, fy14 = fy1 + fy4,
///                  fy23 = fy2 + fy3, of channels fx1 fy1 fz1 fx2 ... fz4                     (4)
/// CAL_MATRIX makes F and M_O of six (type 4, 6 × 6) or eight (type 5, 6 × 8) channels, and the
/// forces of transducers of eight (type 7, 8 × 8) or twelve (type 6, 12 × 12).
struct Wrench {
  Eigen::Vector3d force, moment;  // [N], [N·m]
};
Wrench compute_wrench(const ForcePlatform& platform, const Eigen::VectorXd& channels);

/// Where the force's line meets the surface, p_CQ in P, and the moment about z that is left there:
///   x = -My / Fz,  y = Mx / Fz,  Tz = Mz - x Fy + y Fx                                       (5)
struct CenterOfPressure {
  Eigen::Vector3d p_CQ;
  double free_moment = 0.0;
};
CenterOfPressure compute_center(const Wrench& wrench);

/// Forces of all platforms of a file that was read whole. O(samples).
ForcePlatforms compute_forces(const C3dFile& file, const ForcePlatformOptions& options = {});

}  // namespace sinew
