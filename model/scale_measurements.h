#pragma once

#include <string>
#include <utility>
#include <vector>

#include "data/marker_trajectories.h"
#include "data/scale_setup.h"
#include "model/musculoskeletal_model.h"
#include "model/scaling.h"

namespace sinew {

/// How far apart two markers are on the subject and on the model.
struct MeasuredPair {
  std::string first, second;
  double recorded = kNaN;  // mean over the frames in which both are measured [m]
  double model = kNaN;     // in the default pose [m]
  int frames = 0;          // that the mean is of
};

/// What came of one measurement.
struct MeasuredScale {
  std::string name;
  double factor = kNaN;  // mean over the pairs of recorded / model; NaN: not used
  std::vector<MeasuredPair> pairs;
};

struct MeasuredFactors {
  ScaleFactors factors;
  std::vector<MeasuredScale> measurements;  // those that apply, in order
  std::vector<Warning> warnings;  // measurements that are not used, and why; unknown bodies
};

/// The scale factors that a ModelScaler asks for, step by step: measurements set the axes that they
/// name, manual scales all axes of their body; later ones overwrite earlier ones. As in OpenSim a
/// measurement counts only if all its markers are in the model and in the recording. Unlike
/// OpenSim, which gives a measurement up for one blank, frames in which a marker of a pair is not
/// measured are left out. `recording` may be null if no measurement applies. Throws InputError if
/// it is needed and null, or if two markers of a pair are in one place.
MeasuredFactors measured_factors(const MusculoskeletalModel& model, const ModelScalerSetup& scaler,
                                 const MarkerFile* recording);

/// First and last frame of a time range as OpenSim takes them: from the last frame at or before
/// `from` to the first one at or after `to`.
std::pair<int, int> frames_around(const MarkerTrajectories& markers, std::optional<double> from,
                                  std::optional<double> to);

}  // namespace sinew
