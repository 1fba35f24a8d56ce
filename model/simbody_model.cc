#include "model/simbody_model.h"

#include <fmt/format.h>

#include <utility>

namespace sinew {
namespace {

// A CompiledFunction as Simbody wants it: of one argument, of any derivative order.
class SimbodyFunction : public SimTK::Function {
 public:
  explicit SimbodyFunction(const ScalarFunction& function) : function_(function) {}
  SimTK::Real calcValue(const SimTK::Vector& x) const override { return function_.value(x[0]); }
  SimTK::Real calcDerivative(const SimTK::Array_<int>& components,
                             const SimTK::Vector& x) const override {
    return function_.derivative(x[0], static_cast<int>(components.size()));
  }
  int getArgumentSize() const override { return 1; }
  int getMaxDerivativeOrder() const override { return 4; }

 private:
  CompiledFunction function_;
};

// dependent − function(independent), whose root a coupler keeps; arguments in that order reversed,
// as CoordinateCoupler hands them over: (independent, dependent).
class CouplerFunction : public SimTK::Function {
 public:
  explicit CouplerFunction(const ScalarFunction& function) : function_(function) {}
  SimTK::Real calcValue(const SimTK::Vector& x) const override {
    return function_.value(x[0]) - x[1];
  }
  SimTK::Real calcDerivative(const SimTK::Array_<int>& components,
                             const SimTK::Vector& x) const override {
    int by_dependent = 0;
    for (const int c : components) by_dependent += c == 1 ? 1 : 0;
    if (by_dependent > 0) return components.size() == 1 ? -1.0 : 0.0;
    return function_.derivative(x[0], static_cast<int>(components.size()));
  }
  int getArgumentSize() const override { return 2; }
  int getMaxDerivativeOrder() const override { return 2; }

 private:
  CompiledFunction function_;
};

SimTK::Body::Rigid rigid_body(const Body& body) {
  const Eigen::Matrix3d& I = body.I_BCm;
  try {
    const SimTK::Inertia about_mass_centre(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
    const SimTK::Inertia about_origin =
        about_mass_centre.shiftFromMassCenter(to_simtk(body.p_BCm), body.mass);
    return SimTK::Body::Rigid(SimTK::MassProperties(body.mass, to_simtk(body.p_BCm), about_origin));
  } catch (const std::exception& error) {
    throw InputError(body.source,
                     {fmt::format("Simbody rejects the mass properties of body '{}'", body.name),
                      "an inertia that a real body can have", error.what(),
                      "Correct mass, mass centre or inertia."});
  }
}

// The pose that a custom joint without coordinates keeps.
RigidTransform constant_pose(const Joint& joint) {
  RigidTransform X;
  for (std::size_t i = 0; i < 6; ++i) {
    const TransformAxis& step = joint.axes[i];
    const double value = CompiledFunction(step.function).value(0.0);
    if (i < 3) {
      X.R = X.R * Eigen::AngleAxisd(value, step.axis.normalized()).toRotationMatrix();
    } else {
      X.p += value * step.axis.normalized();
    }
  }
  return X;
}

SimTK::MobilizedBody function_based(SimTK::MobilizedBody& parent, const SimTK::Body& body,
                                    const Joint& joint) {
  SimTK::Array_<const SimTK::Function*> functions;
  SimTK::Array_<SimTK::Array_<int>> arguments;
  SimTK::Array_<SimTK::Vec3> axes;
  for (std::size_t i = 0; i < 6; ++i) {
    const TransformAxis& step = joint.axes[i];
    // Simbody's velocity Jacobian takes a turn without an argument for zero, so a constant becomes
    // a function of the first coordinate too.
    ScalarFunction function = step.function;
    if (step.coordinate < 0) function = {ConstantFunction{CompiledFunction(function).value(0.0)}};
    functions.push_back(new SimbodyFunction(function));
    const int argument = step.coordinate < 0 ? 0 : step.coordinate - joint.coordinates.front();
    arguments.push_back(SimTK::Array_<int>(1, argument));
    axes.push_back(to_simtk(step.axis));  // Simbody takes its direction only
  }
  return SimTK::MobilizedBody::FunctionBased(
      parent, to_simtk(joint.X_PF), body, to_simtk(joint.X_BM),
      static_cast<int>(joint.coordinates.size()), functions, arguments, axes);
}

SimTK::MobilizedBody add_mobilizer(SimTK::MobilizedBody& parent, const SimTK::Body& body,
                                   const Joint& joint) {
  using SimTK::MobilizedBody;
  const SimTK::Transform F = to_simtk(joint.X_PF), M = to_simtk(joint.X_BM);
  switch (joint.kind) {
    case Joint::Kind::kWeld:
      return MobilizedBody::Weld(parent, F, body, M);
    case Joint::Kind::kPin:
      return MobilizedBody::Pin(parent, F, body, M);
    case Joint::Kind::kSlider:
      return MobilizedBody::Slider(parent, F, body, M);
    case Joint::Kind::kUniversal:
      return MobilizedBody::Universal(parent, F, body, M);
    case Joint::Kind::kBall:
      return MobilizedBody::Ball(parent, F, body, M);
    case Joint::Kind::kGimbal:
      return MobilizedBody::Gimbal(parent, F, body, M);
    case Joint::Kind::kPlanar:
      return MobilizedBody::Planar(parent, F, body, M);
    case Joint::Kind::kFree:
      return MobilizedBody::Free(parent, F, body, M);
    case Joint::Kind::kEllipsoid:
      return MobilizedBody::Ellipsoid(parent, F, body, M, to_simtk(joint.radii));
    case Joint::Kind::kCustom:
      break;
  }
  if (joint.coordinates.empty()) {
    return MobilizedBody::Weld(parent, to_simtk(joint.X_PF * constant_pose(joint)), body, M);
  }
  return function_based(parent, body, joint);
}

}  // namespace

RigidTransform to_eigen(const SimTK::Transform& X) {
  RigidTransform result;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) result.R(i, j) = X.R()[i][j];
    result.p[i] = X.p()[i];
  }
  return result;
}

SimTK::Transform to_simtk(const RigidTransform& X) {
  SimTK::Mat33 R;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) R(i, j) = X.R(i, j);
  }
  // Trusted as it is: re-orthogonalizing would move it by rounding and break agreement to 1e-12.
  return {SimTK::Rotation(R, true), to_simtk(X.p)};
}

SimbodyModel::SimbodyModel(const MusculoskeletalModel& model) : SimbodyModel(model, Options{}) {}

SimbodyModel::SimbodyModel(const MusculoskeletalModel& model, const Options& options)
    : system_(std::make_unique<SimTK::MultibodySystem>()),
      matter_(std::make_unique<SimTK::SimbodyMatterSubsystem>(*system_)),
      forces_(std::make_unique<SimTK::GeneralForceSubsystem>(*system_)) {
  matter_->setShowDefaultGeometry(false);
  SimTK::Force::UniformGravity(*forces_, *matter_, to_simtk(model.gravity));
  bodies_.push_back(matter_->getGround().getMobilizedBodyIndex());
  mobilizer_.resize(model.coordinates.size());
  mobilizer_q_.resize(model.coordinates.size());
  for (const Joint& joint : model.joints) {
    SimTK::MobilizedBody& parent =
        matter_->updMobilizedBody(bodies_[static_cast<std::size_t>(joint.parent)]);
    const SimTK::MobilizedBody body = add_mobilizer(
        parent, rigid_body(model.bodies[static_cast<std::size_t>(joint.child)]), joint);
    bodies_.push_back(body.getMobilizedBodyIndex());
    for (std::size_t i = 0; i < joint.coordinates.size(); ++i) {
      const auto c = static_cast<std::size_t>(joint.coordinates[i]);
      mobilizer_[c] = body.getMobilizedBodyIndex();
      mobilizer_q_[c] = SimTK::MobilizerQIndex(static_cast<int>(i));
    }
  }
  add_constraints(model, options);
  index_coordinates(model);
}

void SimbodyModel::add_constraints(const MusculoskeletalModel& model, const Options& options) {
  using SimTK::Constraint;
  if (options.couplers_as_constraints) {
    for (const CoordinateCoupler& coupler : model.couplers) {
      const auto from = static_cast<std::size_t>(coupler.independent);
      const auto to = static_cast<std::size_t>(coupler.dependent);
      SimTK::Array_<SimTK::MobilizedBodyIndex> bodies{mobilizer_[from], mobilizer_[to]};
      SimTK::Array_<SimTK::MobilizerQIndex> qs{mobilizer_q_[from], mobilizer_q_[to]};
      Constraint::CoordinateCoupler(*matter_, new CouplerFunction(coupler.function), bodies, qs);
    }
  }
  if (!options.loops_as_constraints) return;
  const auto mobilized = [&](int body) -> SimTK::MobilizedBody& {
    return matter_->updMobilizedBody(bodies_[static_cast<std::size_t>(body)]);
  };
  for (const WeldConstraint& weld : model.welds) {
    Constraint::Weld(mobilized(weld.body1), to_simtk(weld.X_B1F1), mobilized(weld.body2),
                     to_simtk(weld.X_B2F2));
  }
  for (const PointConstraint& point : model.point_constraints) {
    Constraint::Ball(mobilized(point.body1), to_simtk(point.p_B1P1), mobilized(point.body2),
                     to_simtk(point.p_B2P2));
  }
}

void SimbodyModel::index_coordinates(const MusculoskeletalModel& model) {
  SimTK::State state = system_->realizeTopology();
  matter_->setUseEulerAngles(state, true);
  system_->realizeModel(state);
  std::vector<double> defaults;
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    const SimTK::MobilizedBody& body = matter_->getMobilizedBody(mobilizer_[c]);
    q_index_.push_back(body.getFirstQIndex(state) + static_cast<int>(mobilizer_q_[c]));
    u_index_.push_back(body.getFirstUIndex(state) + static_cast<int>(mobilizer_q_[c]));
    defaults.push_back(model.coordinates[c].default_value);
  }
  set_q(state, defaults);
  default_state_ = state;
}

void SimbodyModel::set_q(SimTK::State& state, std::span<const double> q) const {
  SimTK::Vector& state_q = state.updQ();
  for (std::size_t c = 0; c < q_index_.size(); ++c) state_q[q_index_[c]] = q[c];
}

void SimbodyModel::get_q(const SimTK::State& state, std::span<double> q) const {
  const SimTK::Vector& state_q = state.getQ();
  for (std::size_t c = 0; c < q_index_.size(); ++c) q[c] = state_q[q_index_[c]];
}

}  // namespace sinew
