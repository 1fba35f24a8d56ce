#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data/numbers.h"
#include "data/time_table.h"

namespace sinew {

/// How far a column x of a result is from the column y of the same name in the truth, over the rows
/// where both are numbers. In the columns' own unit.
struct ColumnComparison {
  std::string label;
  int rows = 0;                  // compared
  double mean = kNaN;            // of x − y
  double rms = kNaN;             // of x − y
  double max = kNaN;             // of |x − y|
  double time_of_max = kNaN;     // [s]
  double peak = kNaN;            // of |y|
  double roughness = kNaN;       // RMS of the second derivative of x, see compare_tables
  double true_roughness = kNaN;  // the same of y

  /// max in per cent of the peak; NaN where the truth is zero throughout.
  double max_percent() const { return peak > 0.0 ? 100.0 * max / peak : kNaN; }
  /// How much more x bends than y: 1 is as smooth as the truth. NaN where y does not bend.
  double roughness_ratio() const {
    return true_roughness > 0.0 ? roughness / true_roughness : kNaN;
  }
};

struct TableComparison {
  int rows = 0;                           // of the result that were compared
  double from = 0.0, to = 0.0;            // their times [s]
  bool interpolated = false;              // the truth is sampled at other times
  std::vector<ColumnComparison> columns;  // in the result's order
  std::vector<std::string> only_in_result, only_in_truth;
};

struct ComparisonOptions {
  std::optional<double> from = {}, to = {};  // times to compare [s]
};

/// Compares two tables column by column at the result's times that lie within the truth's. Where
/// the truth has no row within a thousandth of its step of such a time, it is interpolated by a
/// cubic natural spline. Of rows at one time the first counts.
/// Second derivatives are the divided differences of three rows that follow each other,
///   2 ((x₃ − x₂)/(t₃ − t₂) − (x₂ − x₁)/(t₂ − t₁)) / (t₃ − t₁)                                (1)
/// Throws InputError, naming both paths, for tables without a common column or time, and where one
/// is in degrees and the other in radians. O(rows · columns).
TableComparison compare_tables(const TimeTableFile& result, const TimeTableFile& truth,
                               const ComparisonOptions& options = {});

}  // namespace sinew
