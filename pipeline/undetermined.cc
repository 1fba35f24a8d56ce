#include "pipeline/undetermined.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "model/limb_paths.h"
#include "pipeline/option_checks.h"
#include "pipeline/reports.h"

namespace sinew {
namespace {

constexpr const char* kKey = "undetermined";

}  // namespace

std::vector<VerdictReason> coverage_reasons(const IkJob& job, const TrackingResult& result) {
  std::vector<VerdictReason> reasons = coverage_reasons(
      job.model, marker_coverage(job.model, job.tree, job.tracking, job.recording.markers,
                                 job.options.first_frame, &result));
  const double rms = total_marker_rms(result);
  const std::string causes = misfit_causes(job.model, job.tree, job.tracking, rms);
  if (!causes.empty()) {
    VerdictReason reason;
    reason.weight = VerdictReason::Weight::kUnusable;
    reason.code = "not-this-person";
    reason.text = causes;
    reason.figure = 1e3 * rms;
    reason.limit = 1e3 * kNoPerson;
    reason.unit = "mm";
    reason.source = "Sinew";
    for (const Coordinate& c : job.model.coordinates) reason.angles.push_back(c.name);
    reason.torques = reason.angles;
    reasons.push_back(std::move(reason));
  }
  return reasons;
}

std::vector<Warning> as_warnings(const std::vector<VerdictReason>& reasons,
                                 const std::string& file) {
  std::vector<Warning> warnings;
  for (const VerdictReason& reason : reasons) {
    warnings.push_back({{file}, reason.text + (reason.remedy.empty() ? "" : "; " + reason.remedy)});
  }
  return warnings;
}

std::vector<std::string> undetermined_names(const std::vector<VerdictReason>& reasons) {
  std::vector<std::string> names;
  for (const VerdictReason& reason : reasons) {
    if (reason.code != "segment-without-marker" && reason.code != "undetermined-coordinates") {
      continue;
    }
    names.insert(names.end(), reason.angles.begin(), reason.angles.end());
  }
  return names;
}

void set_undetermined(const std::vector<std::string>& names, TimeTable& motion) {
  if (!names.empty()) motion.header[kKey] = fmt::format("{}", fmt::join(names, ","));
}

std::vector<std::string> undetermined_in(const TimeTable& motion) {
  const auto found = motion.header.find(kKey);
  return found == motion.header.end() ? std::vector<std::string>() : split_names(found->second);
}

void mark_undetermined(const std::vector<std::string>& names, TimeTable& forces) {
  const Eigen::Index columns = forces.values.cols();
  forces.values.conservativeResize(Eigen::NoChange,
                                   columns + static_cast<Eigen::Index>(names.size()));
  forces.values.rightCols(static_cast<Eigen::Index>(names.size())).setZero();
  for (const std::string& name : names) forces.labels.push_back(name + "_determined");
}

void mark_stretches(const IkJob& job, TimeTable& forces) {
  const Eigen::Index frames = forces.values.rows();
  std::map<int, Eigen::VectorXd> determined;  // by coordinate
  for (const UndeterminedStretch& stretch : job.stretches) {
    const Eigen::Index first = stretch.first - job.options.first_frame;
    const Eigen::Index from = std::clamp<Eigen::Index>(first - job.reach, 0, frames);
    const Eigen::Index to = std::clamp<Eigen::Index>(first + stretch.count + job.reach, 0, frames);
    for (const int c : stretch.coordinates) {
      const int joint = job.model.coordinates[static_cast<std::size_t>(c)].joint;
      const int body = job.model.joints[static_cast<std::size_t>(joint)].child;
      for (const int hanging : torques_with(job.model, body)) {
        const auto column = determined.try_emplace(hanging, Eigen::VectorXd::Ones(frames)).first;
        column->second.segment(from, to - from).setZero();
      }
    }
  }
  for (const auto& [c, values] : determined) {
    const std::string label =
        job.model.coordinates[static_cast<std::size_t>(c)].name + "_determined";
    if (forces.find_column(label) >= 0) continue;
    forces.labels.push_back(label);
    forces.values.conservativeResize(Eigen::NoChange, forces.values.cols() + 1);
    forces.values.rightCols(1) = values;
  }
}

double filter_reach(double cutoff) { return cutoff > 0.0 ? 0.5 / cutoff : 0.0; }

}  // namespace sinew
