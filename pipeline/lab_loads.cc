#include "pipeline/lab_loads.h"

#include <fmt/format.h>

#include <algorithm>

#include "data/force_table.h"
#include "data/text.h"
#include "pipeline/ground_reaction.h"
#include "pipeline/reports.h"

namespace sinew {
namespace {

using State = PlateContact::State;

// What a contact is decided to be: a foot's name, `none` by the user's word, or `unusable`.
std::string value_of(const PlateContact& contact, const FootAssignment& assignment) {
  if (contact.state == State::kAssigned) {
    return assignment.feet[static_cast<std::size_t>(contact.foot)].name;
  }
  return contact.state == State::kNobody ? "none" : "unusable";
}

// `contact 2.1`: the first on platform 2.
std::vector<std::string> names_of(const FootAssignment& assignment,
                                  const std::vector<ForcePlatformRecording>& plates) {
  std::vector<std::string> names;
  int plate = -1, count = 0;
  for (const PlateContact& contact : assignment.contacts) {
    count = contact.plate == plate ? count + 1 : 1;
    plate = contact.plate;
    names.push_back(fmt::format("contact {}.{}",
                                plates[static_cast<std::size_t>(plate)].platform.number, count));
  }
  return names;
}

Decision decision_of(const std::string& name, const PlateContact& contact,
                     const FootAssignment& assignment, int platform) {
  Decision decision;
  decision.name = name;
  decision.found = value_of(contact, assignment);
  decision.why = fmt::format("{:.2f} s to {:.2f} s, {:.0f} N{}{}", contact.from, contact.to,
                             contact.peak, contact.reason.empty() ? "" : "; ", contact.reason);
  if (contact.state == State::kAssigned) decision.confidence = contact.confidence;
  decision.option =
      fmt::format("--assign {}:FOOT@{:.2f}-{:.2f}", platform, contact.from, contact.to);
  return decision;
}

// Rows of a table by a flag.
TimeTable rows_where(const TimeTable& table, const std::vector<bool>& wanted) {
  TimeTable result = table;
  const auto count = std::count(wanted.begin(), wanted.end(), true);
  result.time.resize(count);
  result.values.resize(count, table.values.cols());
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!wanted[i]) continue;
    result.time[row] = table.time[static_cast<Eigen::Index>(i)];
    result.values.row(row++) = table.values.row(static_cast<Eigen::Index>(i));
  }
  return result;
}

}  // namespace

bool has_platforms(const std::vector<ForcePlatformRecording>& plates) {
  return std::any_of(plates.begin(), plates.end(), [](const auto& plate) {
    return plate.platform.usable() && plate.platform.has_moments;
  });
}

FootAssignment settle_contacts(std::vector<ForcePlatformRecording>& plates,
                               const MarkerTrajectories& markers, const std::string& path,
                               const MusculoskeletalModel& model, double threshold,
                               double marker_cutoff, const LabOptions& options, DecisionLog& log) {
  const double cutoff = log.settle_number({"force cutoff",
                                           {},
                                           marker_cutoff,
                                           "[Hz] as the markers'",
                                           {},
                                           "",
                                           "--force-cutoff",
                                           Decision::Range::kCutoff});
  PrepareOptions prepare;
  prepare.threshold = threshold;
  if (cutoff > 0.0) prepare.force_cutoff = cutoff;
  condition_plates(plates, prepare);
  const std::vector<Foot> feet = feet_of(markers, path, &model);
  const FootAssignment found = assign_feet(markers, feet, plates, threshold, {});
  const FootAssignment said =
      assign_feet(markers, feet, plates, threshold, parse_overrides(options.assign));
  const std::vector<std::string> names = names_of(found, plates);
  std::vector<AssignmentOverride> overrides;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const PlateContact& contact = found.contacts[i];
    const int platform = plates[static_cast<std::size_t>(contact.plate)].platform.number;
    if (said.contacts[i].overridden) {
      log.say(names[i], value_of(said.contacts[i], said), options.given_now.contains("--assign"));
    }
    const Decision decision = decision_of(names[i], contact, found, platform);
    const std::string value = log.settle_text(decision);
    if (value == decision.found.get_ref<const std::string&>()) continue;
    // Half a sample beyond, so that the middle of a contact of one sample lies within.
    overrides.push_back(
        {platform, value == "unusable" ? "none" : value, contact.from - 1e-6, contact.to + 1e-6});
  }
  return assign_feet(markers, feet, plates, threshold, overrides);
}

std::string load_coverage_csv(const LoadCoverage& coverage, const Eigen::VectorXd& time) {
  std::string text = "time_s";
  for (const std::string& foot : coverage.feet) text += fmt::format(",{0},{0}_complete", foot);
  text += "\n";
  for (std::size_t f = 0; f < coverage.loads.size(); ++f) {
    text += text::format_number(time[static_cast<Eigen::Index>(f)]);
    for (const FootLoad load : coverage.loads[f]) {
      text += fmt::format(",{},{}", to_string(load), is_complete(load) ? 1 : 0);
    }
    text += "\n";
  }
  return text;
}

void mark_coverage(const LoadCoverage& coverage, int first, TimeTable& table) {
  const Eigen::Index rows = table.values.rows(), columns = table.values.cols();
  table.values.conservativeResize(rows, columns + static_cast<Eigen::Index>(coverage.feet.size()));
  for (std::size_t foot = 0; foot < coverage.feet.size(); ++foot) {
    table.labels.push_back(coverage.feet[foot] + "_loads_complete");
    for (Eigen::Index row = 0; row < rows; ++row) {
      const auto& loads = coverage.loads[static_cast<std::size_t>(first + row)];
      table.values(row, columns + static_cast<Eigen::Index>(foot)) =
          is_complete(loads[foot]) ? 1.0 : 0.0;
    }
  }
}

nlohmann::ordered_json coverage_summary(const LoadCoverage& coverage, int first,
                                        const MusculoskeletalModel& model,
                                        const TimeTable& torques) {
  nlohmann::ordered_json json;
  const auto rows = static_cast<std::size_t>(torques.time.size());
  LoadCoverage solved{coverage.feet, {}};
  std::vector<bool> complete, incomplete;
  for (std::size_t row = 0; row < rows; ++row) {
    solved.loads.push_back(coverage.loads[static_cast<std::size_t>(first) + row]);
    complete.push_back(solved.complete(row));
    incomplete.push_back(!complete.back());
  }
  for (std::size_t foot = 0; foot < coverage.feet.size(); ++foot) {
    json["feet"][coverage.feet[foot]] = {
        {"complete_frames", solved.complete_frames(foot)},
        {"complete_times", complete_times(solved, foot, torques.time)}};
  }
  json["complete_frames"] = std::count(complete.begin(), complete.end(), true);
  json["frames"] = rows;
  const auto residuals = [&](const std::vector<bool>& wanted) -> nlohmann::ordered_json {
    if (std::find(wanted.begin(), wanted.end(), true) == wanted.end()) return nullptr;
    return id_summary(model, rows_where(torques, wanted))["root_residuals"];
  };
  json["root_residuals_where_complete"] = residuals(complete);
  json["root_residuals_elsewhere"] = residuals(incomplete);
  return json;
}

}  // namespace sinew
