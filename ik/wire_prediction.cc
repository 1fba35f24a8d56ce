#include "ik/wire_prediction.h"

#include <algorithm>

namespace sinew {

using Eigen::Vector3d;

WirePrediction::WirePrediction(const KinematicTree& tree, const IkProblem& problem)
    : excess_(problem.wires.size(), kNaN),
      predicted_(problem.wires.size(), kNaN),
      wrench_(problem.wire_points.size(), Vector6d::Zero()),
      twist_(tree.links.size(), Vector6d::Zero()) {}

void WirePrediction::update(const IkProblem& problem, const KinematicWorkspace& ws,
                            const Vector3d& origin) {
  std::fill(wrench_.begin(), wrench_.end(), Vector6d::Zero());
  for (std::size_t i = 0; i < problem.wires.size(); ++i) {
    const WireResidual& r = problem.wires[i];
    const auto first = static_cast<std::size_t>(r.first_point);
    std::size_t before = first;
    Vector3d p_before = ws.X_WB[static_cast<std::size_t>(problem.wire_points[first].link)] *
                            problem.wire_points[first].p_BP -
                        origin;
    double length = 0.0;
    for (std::size_t k = first + 1; k < first + static_cast<std::size_t>(r.point_count); ++k) {
      const WirePoint& point = problem.wire_points[k];
      if (!is_on_path(point, ws)) continue;
      const Vector3d p = ws.X_WB[static_cast<std::size_t>(point.link)] * point.p_BP - origin;
      const Vector3d along = p - p_before;
      const double stretch = along.norm();
      if (stretch > 0.0) {
        Vector6d line;  // moment and direction of the same line at both of its ends
        line.tail<3>() = along / stretch;
        line.head<3>() = p.cross(line.tail<3>());
        wrench_[k] += line;
        wrench_[before] -= line;
        length += stretch;
      }
      before = k;
      p_before = p;
    }
    excess_[i] = length - r.natural_length;
  }
}

std::span<const double> WirePrediction::predict(const KinematicTree& tree, const IkProblem& problem,
                                                const InternalRows& rows,
                                                const Eigen::VectorXd& d) {
  twist_[0].setZero();
  for (std::size_t b = 1; b < tree.links.size(); ++b) {
    const KinematicTree::Link& link = tree.links[b];
    Vector6d twist = twist_[static_cast<std::size_t>(link.parent)];
    for (int v = link.first_v; v < link.first_v + link.v_count; ++v) {
      const int x = rows.driver(v);
      if (x >= 0) twist += rows.driver_slope(v) * d[x] * rows.twists()[static_cast<std::size_t>(v)];
    }
    twist_[b] = twist;
  }
  for (std::size_t i = 0; i < problem.wires.size(); ++i) {
    const WireResidual& r = problem.wires[i];
    const auto first = static_cast<std::size_t>(r.first_point);
    double length = excess_[i];
    for (std::size_t k = first; k < first + static_cast<std::size_t>(r.point_count); ++k) {
      length += wrench_[k].dot(twist_[static_cast<std::size_t>(problem.wire_points[k].link)]);
    }
    predicted_[i] = length;
  }
  return predicted_;
}

}  // namespace sinew
