#pragma once

#include <string>
#include <vector>

#include "data/time_table.h"
#include "data/verdict_reason.h"
#include "ik/marker_coverage.h"
#include "pipeline/ik_job.h"

namespace sinew {

/// What the tracked markers of a solved job leave open, as reasons of the verdict
/// (ik/marker_coverage.h); and where the markers are too far from the model for a person, code
/// "not-this-person", with the likely causes.
std::vector<VerdictReason> coverage_reasons(const IkJob& job, const TrackingResult& result);

/// The reasons as warnings of a file.
std::vector<Warning> as_warnings(const std::vector<VerdictReason>& reasons,
                                 const std::string& file);

/// Names of the coordinates whose angles cannot be used because nothing measures them: of the codes
/// "segment-without-marker" and "undetermined-coordinates".
std::vector<std::string> undetermined_names(const std::vector<VerdictReason>& reasons);

/// Says in the header of a motion, `undetermined=a,b,c`, which of its columns follow from no
/// marker, so that who reads the motion later can tell; OpenSim keeps such lines and ignores them.
/// Nothing is written for an empty list.
void set_undetermined(const std::vector<std::string>& names, TimeTable& motion);
std::vector<std::string> undetermined_in(const TimeTable& motion);

/// Adds to a table of generalized forces a column `NAME_determined` of zeros for each of the
/// coordinates that nothing measures, beside the columns `…_loads_complete` and in the same sense:
/// 0 where a torque cannot be used. A coordinate without such a column is determined.
void mark_undetermined(const std::vector<std::string>& names, TimeTable& forces);

/// The same for coordinates that gaps leave undetermined for a while, and for those whose torque
/// hangs on them (torques_with()): 0 in the job's stretches and as far beside them as filters carry
/// (IkInputs::reach), 1 elsewhere. Rows of `forces` are the frames that were solved.
void mark_stretches(const IkJob& job, TimeTable& forces);

/// How far a zero-lag low-pass carries what stands in a gap beyond it [s]: half a period of its
/// cutoff [Hz], after which the response of a Butterworth filter of fourth order has gone below a
/// hundredth. Not positive: 0.
double filter_reach(double cutoff);

}  // namespace sinew
