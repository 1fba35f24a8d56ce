#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "data/marker_table.h"
#include "data/table_comparison.h"
#include "dynamics/coordinate_table.h"
#include "pipeline/command.h"
#include "pipeline/model_choice.h"
#include "pipeline/option_checks.h"
#include "pipeline/recording.h"

namespace sinew {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
std::string cell(double value, const char* format) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

// "a, b, c and 12 more"
std::string some_of(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 5;
  const auto end = names.begin() + static_cast<std::ptrdiff_t>(std::min(kShown, names.size()));
  const std::string text = fmt::format("{}", fmt::join(names.begin(), end, ", "));
  return names.size() > kShown ? fmt::format("{} and {} more", text, names.size() - kShown) : text;
}

struct CompareCommand {
  std::string result, truth;
  ModelChoice model;
  ComparisonOptions options;
  int worst = 0;  // 0: all columns in the table's order
  std::optional<double> tolerance, percent;
  bool json = false;
  std::vector<Warning> warnings;

  int run() {
    const std::optional<MusculoskeletalModel> description =
        model.name.empty() ? std::nullopt : std::optional(model.load());
    if (description) report(warnings, description->warnings);
    const TimeTableFile a = read(result, description), b = read(truth, description);
    TableComparison comparison = compare_tables(a, b, options);
    const std::vector<const ColumnComparison*> beyond = beyond_tolerance(comparison);
    if (json) {
      fmt::print("{}\n", to_json(comparison, beyond).dump(2));
    } else {
      fmt::print("{}", to_text(comparison, beyond));
    }
    return beyond.empty() ? kExitOk : kExitFailed;
  }

  TimeTableFile read(const std::string& path,
                     const std::optional<MusculoskeletalModel>& description) {
    if (format_of(path) == Format::kC3d) {
      throw std::invalid_argument(path + " is a C3D file: convert it first, with sinew convert");
    }
    Recording recording = read_recording(path, warnings);
    TimeTableFile file{path, {}, {}};
    file.table = recording.table ? std::move(*recording.table) : marker_table(*recording.markers);
    return description ? coordinates_of(*description, file) : file;
  }

  // Coordinates in degrees and metres under the model's names, virtual links left out.
  TimeTableFile coordinates_of(const MusculoskeletalModel& description, const TimeTableFile& file) {
    const CoordinateTable motion = coordinate_table(description, file);
    report(warnings, motion.warnings);
    TimeTableFile out{file.path, {}, {}};
    out.table.in_degrees = true;
    out.table.time = motion.time;
    std::vector<Eigen::Index> columns;
    for (std::size_t c = 0; c < description.coordinates.size(); ++c) {
      const Coordinate& coordinate = description.coordinates[c];
      const auto child = static_cast<std::size_t>(
          description.joints[static_cast<std::size_t>(coordinate.joint)].child);
      if (!motion.measured[c] || description.bodies[child].virtual_link) continue;
      out.table.labels.push_back(coordinate.name);
      columns.push_back(static_cast<Eigen::Index>(c));
    }
    out.table.values = motion.q(Eigen::all, columns);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const auto c = static_cast<std::size_t>(columns[i]);
      if (description.coordinates[c].motion != Coordinate::Motion::kRotational) continue;
      out.table.values.col(static_cast<Eigen::Index>(i)) *= 180.0 / std::numbers::pi;
    }
    return out;
  }

  std::vector<const ColumnComparison*> beyond_tolerance(const TableComparison& comparison) const {
    std::vector<const ColumnComparison*> beyond;
    for (const ColumnComparison& c : comparison.columns) {
      // Also where nothing could be compared.
      const bool within = (!tolerance || c.max <= *tolerance) &&
                          (!percent || c.max_percent() <= *percent || c.max == 0.0);
      if (!within) beyond.push_back(&c);
    }
    return beyond;
  }

  std::vector<ColumnComparison> shown(const TableComparison& comparison) const {
    std::vector<ColumnComparison> columns = comparison.columns;
    if (worst == 0) return columns;
    const auto badness = [this](const ColumnComparison& c) {
      const double value = percent ? c.max_percent() : c.max;
      return std::isnan(value) ? -1.0 : value;
    };
    std::stable_sort(columns.begin(), columns.end(),
                     [&](const auto& x, const auto& y) { return badness(x) > badness(y); });
    columns.resize(std::min(columns.size(), static_cast<std::size_t>(worst)));
    return columns;
  }

  std::string tolerance_text() const {
    std::string text;
    if (tolerance) text = fmt::format("{:g}", *tolerance);
    if (percent) text += fmt::format("{}{:g} % of the peak", text.empty() ? "" : " or ", *percent);
    return text;
  }

  std::string to_text(const TableComparison& comparison,
                      const std::vector<const ColumnComparison*>& beyond) const {
    std::string text = fmt::format(
        "{} against {}: {} rows, {:.6g} s to {:.6g} s{}\n", result, truth, comparison.rows,
        comparison.from, comparison.to,
        comparison.interpolated ? ", the latter interpolated at the former's times" : "");
    text += fmt::format("{:<36} {:>11} {:>11} {:>9} {:>11} {:>9} {:>7}\n", "column", "RMS", "max",
                        "at s", "peak", "max %", "rough");
    for (const ColumnComparison& c : shown(comparison)) {
      text += fmt::format("{:<36} {:>11} {:>11} {:>9} {:>11} {:>9} {:>7}\n", c.label,
                          cell(c.rms, "{:.4g}"), cell(c.max, "{:.4g}"),
                          cell(c.time_of_max, "{:.4g}"), cell(c.peak, "{:.4g}"),
                          cell(c.max_percent(), "{:.3g}"), cell(c.roughness_ratio(), "{:.3g}"));
    }
    const auto left_out = [&](const std::vector<std::string>& names, const std::string& path) {
      if (names.empty()) return;
      text += fmt::format("only in {}: {} column{}: {}\n", path, names.size(),
                          names.size() == 1 ? "" : "s", some_of(names));
    };
    left_out(comparison.only_in_result, result);
    left_out(comparison.only_in_truth, truth);
    if (tolerance || percent) {
      std::vector<std::string> names;
      for (const ColumnComparison* c : beyond) names.push_back(c->label);
      text += beyond.empty()
                  ? fmt::format("all columns within {}\n", tolerance_text())
                  : fmt::format("{} of {} columns beyond {}: {}\n", beyond.size(),
                                comparison.columns.size(), tolerance_text(), some_of(names));
    }
    return text;
  }

  Json to_json(const TableComparison& comparison,
               const std::vector<const ColumnComparison*>& beyond) const {
    Json columns = Json::array();
    for (const ColumnComparison& c : shown(comparison)) {
      columns.push_back({{"name", c.label},
                         {"rows", c.rows},
                         {"mean", number(c.mean)},
                         {"rms", number(c.rms)},
                         {"max", number(c.max)},
                         {"time_of_max_s", number(c.time_of_max)},
                         {"peak", number(c.peak)},
                         {"max_percent", number(c.max_percent())},
                         {"roughness", number(c.roughness)},
                         {"true_roughness", number(c.true_roughness)}});
    }
    Json out = {{"result", result},
                {"truth", truth},
                {"rows", comparison.rows},
                {"from_s", comparison.from},
                {"to_s", comparison.to},
                {"interpolated", comparison.interpolated},
                {"columns", columns},
                {"only_in_result", comparison.only_in_result},
                {"only_in_truth", comparison.only_in_truth}};
    if (tolerance || percent) out["beyond_tolerance"] = beyond.size();
    return out;
  }
};

}  // namespace

void add_compare_command(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<CompareCommand>();
  CLI::App* sub = app.add_subcommand(
      "compare", "How far the columns of a table are from those of another: angles, torques, ...");
  sub->add_option("result", command->result, "The table in question (.mot, .sto, .csv, .trc)")
      ->required();
  sub->add_option("truth", command->truth, "What it is compared with")->required();
  sub->add_option("--model", command->model.name,
                  "Model (.osim, whole-body or whole-body-detailed) of joint angles: compares its "
                  "coordinates in degrees and metres, whatever their labels and units, without "
                  "virtual links");
  sub->add_option("--from", command->options.from, "First time to compare [s]")->check(a_time());
  sub->add_option("--to", command->options.to, "Last time to compare [s]")->check(a_time());
  sub->add_option("--worst", command->worst, "Show only so many columns, the farthest first")
      ->check(a_stride());
  sub->add_option("--tolerance", command->tolerance,
                  "Fail if a column is farther away anywhere, in its own unit")
      ->check(zero_or_more());
  sub->add_option("--percent", command->percent,
                  "Fail if a column is farther away anywhere than so much of the truth's peak [%]; "
                  "orders --worst")
      ->check(zero_or_more());
  sub->add_flag("--json", command->json, "Print JSON");
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace sinew
