#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "data/force_platform.h"
#include "data/numbers.h"
#include "data/time_table.h"

namespace sinew {

/// Turns a platform and what it measured into other axes M: R_MW.
void rotate(ForcePlatformRecording& recording, const Eigen::Matrix3d& R_MW);

struct ForceConditioning {
  std::optional<double> cutoff = {};  // zero-lag low-pass [Hz]; none where empty
  std::optional<double> rate = {};    // resample at [Hz]; as it is where empty
  double threshold = kContactForce;   // as ForcePlatformOptions::threshold [N]
};

/// Filters and resamples force and moment about the platform's centre C, a fixed point, and
/// computes the centre of pressure anew: a filtered centre would lie anywhere while forces are
/// small. Below the threshold, and where it pulls, force, moment and free moment become zero. The
/// centre of pressure stays NaN there. Platforms that cannot be used stay as they are. Throws
/// std::invalid_argument for a cutoff that is not below half the rate.
void condition(ForcePlatformRecording& recording, const ForceConditioning& conditioning);

/// Columns plateN_force_vx … plateN_force_px … plateN_torque_x … of every usable platform with
/// moments, as OpenSim's external loads take them: force [N] and free moment [N m] on the subject,
/// centre of pressure [m]. Where nothing presses it goes on a straight line in time from where it
/// was to where it will be, and is the platform's centre if nothing ever does, so that a spline
/// through the columns makes no jump. Time 0 at the first frame.
TimeTable force_table(const std::vector<ForcePlatformRecording>& recordings);

/// Fills rows that are NaN on a straight line between their neighbours, level at the ends; `whole`
/// where every row is NaN.
void fill_centers(RowMatrix& centers, const Eigen::Vector3d& whole);

}  // namespace sinew
