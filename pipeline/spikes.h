#pragma once

#include <string>
#include <vector>

#include "data/c3d_file.h"
#include "data/marker_trajectories.h"
#include "data/recording_edits.h"
#include "data/time_table.h"
#include "pipeline/decisions.h"

namespace sinew {

/// Settles which samples of a laboratory's trial are taken as not measured, as decisions
/// `TRIALspikes` and `TRIALforce spikes` with --spikes and --force-spikes: those that
/// find_marker_spikes() and find_sample_spikes() find, `none`, or the ones that an edited
/// decisions.json lists. Nothing is decided where there are none. `trial` as in
/// read_lab_recording(). Throws InputError for a value that is neither a list of NAME@FROM-TO nor
/// `none`.
std::vector<MarkerDrop> settle_spikes(const std::string& trial, const MarkerTrajectories& markers,
                                      DecisionLog& log);
std::vector<SampleDrop> settle_force_spikes(const std::string& trial, const C3dFile& file,
                                            DecisionLog& log);

/// Where no trial is prepared: takes spikes out of the markers, which get gaps there, or out of a
/// table of forces, which goes straight over them, and says so in a warning at `path` that names
/// `option`, which keeps them.
void leave_out_spikes(MarkerTrajectories& markers, const std::string& path,
                      const std::string& option, std::vector<Warning>& warnings);
void leave_out_spikes(TimeTable& table, const std::string& path, std::vector<Warning>& warnings);

}  // namespace sinew
