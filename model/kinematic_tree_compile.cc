#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/kinematic_tree.h"

namespace sinew {
namespace {

using Kind = KinematicTree::Kind;

class Compiler {
 public:
  Compiler(const MusculoskeletalModel& model, const KinematicTree::Options& options)
      : model_(model), options_(options) {}

  KinematicTree compile() {
    tree_.links.emplace_back();  // ground
    tree_.q_of_coordinate.assign(model_.coordinates.size(), -1);
    tree_.v_of_coordinate.assign(model_.coordinates.size(), -1);
    for (const Joint& joint : model_.joints) add_link(joint);
    add_couplings();
    choose_unknowns();
    return std::move(tree_);
  }

 private:
  bool as_quaternion(const Joint& joint) const {
    return options_.quaternions &&
           (joint.kind == Joint::Kind::kBall || joint.kind == Joint::Kind::kFree);
  }

  int add_function(const ScalarFunction& function) {
    tree_.functions.emplace_back(function);
    return static_cast<int>(tree_.functions.size()) - 1;
  }

  // A step by coordinate i of the joint, one to one.
  void add_step(const Joint& joint, std::size_t i, const Eigen::Vector3d& axis, bool turns) {
    const auto c = static_cast<std::size_t>(joint.coordinates[i]);
    tree_.steps.push_back({axis, tree_.q_of_coordinate[c], tree_.v_of_coordinate[c], -1, 0.0});
    ++(turns ? tree_.links.back().rotation_count : tree_.links.back().translation_count);
  }

  void add_custom_steps(const Joint& joint) {
    for (std::size_t i = 0; i < 6; ++i) {
      const TransformAxis& axis = joint.axes[i];
      KinematicTree::Step step;
      step.axis = axis.axis.normalized();
      const CompiledFunction function(axis.function);
      if (axis.coordinate < 0 || function.is_constant()) {
        step.constant = function.value(0.0);
        if (step.constant == 0.0) continue;
      } else {
        step.q = tree_.q_of_coordinate[static_cast<std::size_t>(axis.coordinate)];
        step.v = tree_.v_of_coordinate[static_cast<std::size_t>(axis.coordinate)];
        if (!function.is_identity()) step.function = add_function(axis.function);
      }
      tree_.steps.push_back(step);
      ++(i < 3 ? tree_.links.back().rotation_count : tree_.links.back().translation_count);
    }
  }

  void add_link(const Joint& joint) {
    KinematicTree::Link& link = tree_.links.emplace_back();
    link.parent = joint.parent;
    link.X_PF = joint.X_PF;
    link.X_MB = joint.X_BM.inverse();
    link.radii = joint.radii;
    link.first_q = tree_.q_count();
    link.first_v = tree_.v_count();
    link.first_step = static_cast<int>(tree_.steps.size());
    add_coordinates(joint, link);
    if (as_quaternion(joint)) return;
    using Eigen::Vector3d;
    const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
    link.kind = Kind::kSteps;
    switch (joint.kind) {
      case Joint::Kind::kWeld:
        link.kind = Kind::kWeld;
        break;
      case Joint::Kind::kPin:
        add_step(joint, 0, z, true);
        break;
      case Joint::Kind::kSlider:
        add_step(joint, 0, x, false);
        break;
      case Joint::Kind::kUniversal:
        add_step(joint, 0, x, true);
        add_step(joint, 1, y, true);
        break;
      case Joint::Kind::kEllipsoid:
        link.kind = Kind::kEllipsoid;
        [[fallthrough]];
      case Joint::Kind::kBall:
      case Joint::Kind::kGimbal:
        add_three(joint, 0, true);
        break;
      case Joint::Kind::kPlanar:
        add_step(joint, 0, z, true);
        add_step(joint, 1, x, false);
        add_step(joint, 2, y, false);
        break;
      case Joint::Kind::kFree:
        add_three(joint, 0, true);
        add_three(joint, 3, false);
        break;
      case Joint::Kind::kCustom:
        add_custom_steps(joint);
        break;
    }
  }

  void add_three(const Joint& joint, std::size_t first, bool turns) {
    for (int i = 0; i < 3; ++i) {
      add_step(joint, first + static_cast<std::size_t>(i), Eigen::Vector3d::Unit(i), turns);
    }
  }

  void add_coordinates(const Joint& joint, KinematicTree::Link& link) {
    const int link_index = static_cast<int>(tree_.links.size()) - 1;
    if (as_quaternion(joint)) {
      add_quaternion(joint, link, link_index);
      return;
    }
    for (const int c : joint.coordinates) {
      tree_.q_of_coordinate[static_cast<std::size_t>(c)] = tree_.q_count();
      tree_.v_of_coordinate[static_cast<std::size_t>(c)] = tree_.v_count();
      tree_.q_of_v.push_back(tree_.q_count());
      tree_.link_of_v.push_back(link_index);
      tree_.default_q.push_back(model_.coordinates[static_cast<std::size_t>(c)].default_value);
    }
    link.q_count = link.v_count = static_cast<int>(joint.coordinates.size());
  }

  void add_quaternion(const Joint& joint, KinematicTree::Link& link, int link_index) {
    link.kind = joint.kind == Joint::Kind::kBall ? Kind::kBall : Kind::kFree;
    Eigen::VectorXd defaults(joint.coordinates.size());
    for (std::size_t i = 0; i < joint.coordinates.size(); ++i) {
      const Coordinate& c = model_.coordinates[static_cast<std::size_t>(joint.coordinates[i])];
      const bool held = c.clamped || (!options_.ignore_locks && (c.locked || c.prescribed));
      if (i < 3 && held) {
        throw InputError(c.source,
                         {fmt::format("coordinate '{}' is locked, clamped or prescribed, but its "
                                      "joint is to step as a quaternion",
                                      c.name),
                          "a free coordinate", "", "Use angles for this model."});
      }
      defaults[static_cast<Eigen::Index>(i)] = c.default_value;
    }
    const Eigen::Quaterniond rotation(rotation_from_body_xyz(defaults.head<3>()));
    for (const double value : {rotation.w(), rotation.x(), rotation.y(), rotation.z()}) {
      tree_.default_q.push_back(value);
    }
    link.v_count = static_cast<int>(joint.coordinates.size());
    link.q_count = link.v_count + 1;
    for (int i = 0; i < link.v_count; ++i) {
      int q = -1;
      if (i >= 3) {
        q = tree_.q_count();
        tree_.default_q.push_back(defaults[i]);
        tree_.q_of_coordinate[static_cast<std::size_t>(
            joint.coordinates[static_cast<std::size_t>(i)])] = q;
      }
      tree_.v_of_coordinate[static_cast<std::size_t>(
          joint.coordinates[static_cast<std::size_t>(i)])] = tree_.v_count();
      tree_.q_of_v.push_back(q);
      tree_.link_of_v.push_back(link_index);
    }
  }

  // Couplers in an order in which sources come before what depends on them.
  void add_couplings() {
    std::vector<bool> pending(model_.coordinates.size(), false);
    for (const CoordinateCoupler& c : model_.couplers) {
      pending[static_cast<std::size_t>(c.dependent)] = true;
    }
    tree_.coupling_of_v.assign(static_cast<std::size_t>(tree_.v_count()), -1);
    for (std::size_t placed = 0; placed < model_.couplers.size();) {
      for (const CoordinateCoupler& c : model_.couplers) {
        const auto from = static_cast<std::size_t>(c.independent);
        const auto to = static_cast<std::size_t>(c.dependent);
        if (!pending[to] || pending[from]) continue;
        pending[to] = false;
        ++placed;
        if (tree_.q_of_coordinate[from] < 0 || tree_.q_of_coordinate[to] < 0) {
          throw InputError(
              c.source,
              {fmt::format("coupler '{}' acts on a joint that is to step as a "
                           "quaternion",
                           c.name),
               "coordinates with a value of their own", "", "Use angles for this model."});
        }
        tree_.coupling_of_v[static_cast<std::size_t>(tree_.v_of_coordinate[to])] =
            static_cast<int>(tree_.couplings.size());
        tree_.couplings.push_back({tree_.q_of_coordinate[to], tree_.v_of_coordinate[to],
                                   tree_.q_of_coordinate[from], tree_.v_of_coordinate[from],
                                   add_function(c.function)});
      }
    }
  }

  void choose_unknowns() {
    std::vector<bool> fixed(static_cast<std::size_t>(tree_.v_count()), false);
    for (const KinematicTree::Coupling& c : tree_.couplings) {
      fixed[static_cast<std::size_t>(c.dependent_v)] = true;
    }
    std::vector<const Coordinate*> coordinate_of_v(fixed.size(), nullptr);
    for (std::size_t c = 0; c < model_.coordinates.size(); ++c) {
      const Coordinate& coordinate = model_.coordinates[c];
      const auto v = static_cast<std::size_t>(tree_.v_of_coordinate[c]);
      coordinate_of_v[v] = &coordinate;
      if (options_.ignore_locks) continue;
      if (coordinate.locked) {
        fixed[v] = true;
      } else if (coordinate.prescribed && !fixed[v]) {
        fixed[v] = true;
        tree_.prescribed.push_back(
            {tree_.q_of_coordinate[c], add_function(*coordinate.prescribed)});
      }
    }
    tree_.unknown_of_v.assign(fixed.size(), -1);
    for (std::size_t v = 0; v < fixed.size(); ++v) {
      if (fixed[v]) continue;
      tree_.unknown_of_v[v] = tree_.unknown_count();
      tree_.unknown_v.push_back(static_cast<int>(v));
      const Coordinate* c = coordinate_of_v[v];
      const bool bounded = c != nullptr && c->clamped && tree_.q_of_v[v] >= 0;
      constexpr double kInfinity = std::numeric_limits<double>::infinity();
      tree_.lower.push_back(bounded ? c->range_min : -kInfinity);
      tree_.upper.push_back(bounded ? c->range_max : kInfinity);
    }
  }

  const MusculoskeletalModel& model_;
  const KinematicTree::Options options_;
  KinematicTree tree_;
};

}  // namespace

KinematicTree compile_tree(const MusculoskeletalModel& model) { return compile_tree(model, {}); }

KinematicTree compile_tree(const MusculoskeletalModel& model,
                           const KinematicTree::Options& options) {
  return Compiler(model, options).compile();
}

}  // namespace sinew
