#include "ik/auto_scale_parameters.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <stdexcept>

#include "model/model_check.h"

namespace sinew {
namespace {

// Bodies that share their factors, as disjoint sets; the first body of a set stands for it.
class Groups {
 public:
  explicit Groups(std::size_t bodies) : parent_(bodies) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int find(int body) const {
    while (parent_[static_cast<std::size_t>(body)] != body) {
      body = parent_[static_cast<std::size_t>(body)];
    }
    return body;
  }
  void join(int a, int b) {
    a = find(a);
    b = find(b);
    parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

void join_named(const MusculoskeletalModel& model, const AutoScaleOptions& options,
                Groups& groups) {
  for (const std::vector<std::string>& names : options.groups) {
    int first = -1;
    for (const std::string& name : names) {
      const int body = model.find_body(name);
      if (body < 1) {
        throw std::invalid_argument(fmt::format(
            "AutoScaleOptions.groups names '{}'; expected a body of model '{}'", name, model.name));
      }
      if (first >= 0) groups.join(first, body);
      first = body;
    }
  }
}

void join_sides(const MusculoskeletalModel& model, Groups& groups) {
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    for (const std::string& name : partner_names(model.bodies[b].name)) {
      if (const int partner = model.find_body(name); partner > 0) {
        groups.join(static_cast<int>(b), partner);
      }
    }
  }
}

// A body without markers goes with the only one that it carries, or else with its carrier.
void join_unmarked(const MusculoskeletalModel& model, std::span<const int> tracked,
                   Groups& groups) {
  std::set<int> marked;  // groups: one marked side is enough
  for (const int m : tracked) {
    marked.insert(groups.find(model.markers[static_cast<std::size_t>(m)].body));
  }
  const Groups before = groups;
  std::vector<std::vector<int>> carried(model.bodies.size());
  for (const Joint& joint : model.joints) {
    if (model.bodies[static_cast<std::size_t>(joint.child)].virtual_link) continue;
    carried[static_cast<std::size_t>(joint.parent)].push_back(joint.child);
  }
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    const int body = static_cast<int>(b), carrier = model.joints[b - 1].parent;
    if (marked.contains(before.find(body))) continue;
    if (carried[b].size() == 1) {
      groups.join(body, carried[b][0]);
    } else if (carrier > 0) {
      groups.join(body, carrier);
    }
  }
}

std::vector<AutoScaleParameters::Factor> make_factors(const MusculoskeletalModel& model,
                                                      const Groups& groups,
                                                      AutoScaleOptions::Axes axes) {
  static constexpr const char* kAxes[] = {"x", "y", "z"};
  std::vector<AutoScaleParameters::Factor> factors;
  for (int b = 1; b < static_cast<int>(model.bodies.size()); ++b) {
    if (groups.find(b) != b) continue;
    AutoScaleParameters::Factor factor;
    factor.name = model.bodies[static_cast<std::size_t>(b)].name;
    factor.group = b;
    for (int other = b; other < static_cast<int>(model.bodies.size()); ++other) {
      if (groups.find(other) == b) factor.bodies.push_back(other);
    }
    if (axes == AutoScaleOptions::Axes::kUniform) {
      factors.push_back(factor);
      continue;
    }
    const std::string name = factor.name;
    for (int axis = 0; axis < 3; ++axis) {
      factor.axis = axis;
      factor.name = name + "." + kAxes[axis];
      factors.push_back(factor);
    }
  }
  return factors;
}

Eigen::MatrixXd factor_covariance(const std::vector<AutoScaleParameters::Factor>& factors,
                                  const AutoScaleOptions& options) {
  const auto n = static_cast<Eigen::Index>(factors.size());
  Eigen::MatrixXd C = Eigen::MatrixXd::Constant(n, n, options.size_sd * options.size_sd);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto &a = factors[static_cast<std::size_t>(i)],
                 &b = factors[static_cast<std::size_t>(j)];
      if (a.group == b.group) C(i, j) += options.segment_sd * options.segment_sd;
      if (i == j && a.axis >= 0) C(i, j) += options.axis_sd * options.axis_sd;
    }
  }
  return C;
}

// Priors and limits of everything, the offsets' by whether a marker marks a landmark.
void set_offsets(const MusculoskeletalModel& model, const AutoScaleOptions& options,
                 AutoScaleParameters& parameters) {
  const SizeLimits& limits = options.limits;
  parameters.prior_precision_of_offsets.resize(
      3 * static_cast<Eigen::Index>(parameters.free_markers.size()));
  parameters.upper.setConstant(parameters.count(), std::log(limits.largest_ratio));
  parameters.lower.setConstant(parameters.count(), std::log(limits.smallest_ratio));
  parameters.lower[0] = std::log(limits.smallest_size);
  parameters.upper[0] = std::log(limits.largest_size);
  const auto& technical = options.technical_markers;
  for (std::size_t i = 0; i < parameters.free_markers.size(); ++i) {
    const std::string& name =
        model.markers[static_cast<std::size_t>(parameters.free_markers[i])].name;
    const bool anatomical = std::find(technical.begin(), technical.end(), name) == technical.end();
    const double sd = anatomical ? options.marker_offset_sd : options.technical_marker_sd;
    const double farthest = anatomical ? limits.marker_offset : limits.technical_marker_offset;
    parameters.prior_precision_of_offsets.segment<3>(3 * static_cast<Eigen::Index>(i))
        .setConstant(1.0 / (sd * sd));
    parameters.upper.segment<3>(parameters.offset_of(i)).setConstant(farthest);
    parameters.lower.segment<3>(parameters.offset_of(i)).setConstant(-farthest);
  }
}

}  // namespace

Eigen::MatrixXd AutoScaleParameters::prior_precision() const {
  Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(count(), count());
  const int k = factor_count();
  const Eigen::MatrixXd deviations = (prior_covariance_of_factors.array() - size_sd * size_sd);
  precision(0, 0) = 1.0 / (size_sd * size_sd);
  precision.block(1, 1, k, k) = deviations.llt().solve(Eigen::MatrixXd::Identity(k, k));
  precision.diagonal().tail(count() - 1 - k) = prior_precision_of_offsets;
  return precision;
}

ScaleFactors AutoScaleParameters::scale_factors(const MusculoskeletalModel& model,
                                                const Eigen::VectorXd& theta) const {
  ScaleFactors scale(model);
  for (int i = 0; i < factor_count(); ++i) {
    const Factor& factor = factors[static_cast<std::size_t>(i)];
    for (const int b : factor.bodies) {
      Eigen::Vector3d& f = scale.of_body[static_cast<std::size_t>(b)];
      if (factor.axis < 0) {
        f.setConstant(std::exp(log_factor(theta, i)));
      } else {
        f[factor.axis] = std::exp(log_factor(theta, i));
      }
    }
  }
  return scale;
}

MusculoskeletalModel AutoScaleParameters::apply(const MusculoskeletalModel& model,
                                                const Eigen::VectorXd& theta) const {
  MusculoskeletalModel scaled = scale_geometry(model, scale_factors(model, theta));
  for (std::size_t i = 0; i < free_markers.size(); ++i) {
    scaled.markers[static_cast<std::size_t>(free_markers[i])].p_BM +=
        theta.segment<3>(offset_of(i));
  }
  return scaled;
}

AutoScaleParameters choose_parameters(const MusculoskeletalModel& model,
                                      std::span<const int> tracked,
                                      const AutoScaleOptions& options) {
  Groups groups(model.bodies.size());
  join_named(model, options, groups);
  if (options.tie_sides) join_sides(model, groups);
  join_unmarked(model, tracked, groups);
  AutoScaleParameters parameters;
  parameters.factors = make_factors(model, groups, options.axes);
  parameters.size_sd = options.size_sd;
  parameters.prior_covariance_of_factors = factor_covariance(parameters.factors, options);
  for (const int m : tracked) {
    if (!model.markers[static_cast<std::size_t>(m)].fixed) parameters.free_markers.push_back(m);
  }
  set_offsets(model, options, parameters);
  return parameters;
}

}  // namespace sinew
