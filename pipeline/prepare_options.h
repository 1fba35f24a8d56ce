#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "data/gap_filling.h"
#include "data/laboratory_axes.h"
#include "data/numbers.h"
#include "pipeline/edit_options.h"

namespace sinew {

/// The command-line options that say what is done to a recording before it is solved or written.
struct PrepareOptions {
  std::string up, forward;  // `auto`, `keep` (up only) or an axis; empty: not given
  std::optional<double> marker_cutoff, force_cutoff, analog_cutoff, rate;  // [Hz]
  std::optional<double> max_gap;                                           // [s]
  bool fill_rigid = false;
  std::string segments_from;         // model whose bodies say which markers move together
  double threshold = kContactForce;  // [N]
  EditOptions edit;                  // what is put right before all of this

  void add_to(CLI::App& command);
  std::optional<Eigen::Vector3d> up_axis() const { return parse_axis(up); }
  std::optional<Eigen::Vector3d> forward_axis() const { return parse_axis(forward); }
  bool fills_gaps() const { return max_gap.value_or(0.0) > 0.0 || fill_rigid; }
  /// Whether markers, forces or samples change in time, so that they have to lie in memory whole.
  bool conditions() const {
    return fills_gaps() || marker_cutoff || force_cutoff || analog_cutoff || rate;
  }
};

/// The value of an option that names an axis: x, -z, ..., auto, and keep where it may be kept.
CLI::Validator an_axis(bool may_be_kept);

/// Fills gaps, filters and resamples markers, in this order, and says what was done; warnings are
/// printed and added. Throws std::invalid_argument naming the option for what does not fit.
GapFillResult prepare_markers(MarkerTrajectories& markers, const std::string& path,
                              const PrepareOptions& options, std::vector<Warning>& warnings);

}  // namespace sinew
