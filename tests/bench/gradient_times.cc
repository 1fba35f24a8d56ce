#include <fmt/format.h>

#include <random>

#include "ik/residuals.h"
#include "model/simbody_model.h"
#include "tests/bench/bench_tables.h"
#include "tests/bench/stopwatch.h"
#include "tests/ik/published_trials.h"
#include "tests/ik/small_model.h"

namespace sinew {
namespace {

struct GradientProblem {
  std::string name;
  MusculoskeletalModel model;
  IkProblem problem;  // positions only: what Simbody's side below covers
  IkTargets targets{IkProblem{}};
  KinematicTree tree;
};

// Targets a decimetre off, at the default pose.
void finish(GradientProblem& p) {
  validate(p.model);
  p.tree = compile_tree(p.model);
  p.targets = IkTargets(p.problem);
  KinematicWorkspace ws(p.tree);
  update_poses(p.tree, ws);
  for (std::size_t i = 0; i < p.problem.positions.size(); ++i) {
    const PositionResidual& r = p.problem.positions[i];
    p.targets.positions[i] =
        ws.X_WB[static_cast<std::size_t>(r.link)] * r.p_BP + Eigen::Vector3d(0.1, -0.1, 0.1);
  }
}

// The paper's chain of ball joints: targets on every second link and on the end.
GradientProblem chain(int links) {
  GradientProblem p;
  p.name = fmt::format("chain of {} balls", links);
  p.model = empty_model();
  for (int i = 0, parent = 0; i < links; ++i) {
    parent = add_body(p.model, parent, Joint::Kind::kBall, "rrr", {0, 0, i == 0 ? 0.0 : 0.1});
    if (i % 2 == 1 || i + 1 == links) p.problem.positions.push_back({parent, {0, 0, 0.1}});
  }
  finish(p);
  return p;
}

// A random tree as bushy as a body, three markers on every link.
GradientProblem bush(int links) {
  GradientProblem p;
  p.name = fmt::format("tree of {} balls", links);
  p.model = empty_model();
  std::mt19937 random(1);
  for (int b = 1; b <= links; ++b) {
    const int parent = std::uniform_int_distribution<int>(std::max(0, b - 6), b - 1)(random);
    add_body(p.model, parent, Joint::Kind::kBall, "rrr", {0.05, 0, 0.1});
    for (int axis = 0; axis < 3; ++axis) {
      p.problem.positions.push_back({b, 0.1 * Eigen::Vector3d::Unit(axis)});
    }
  }
  finish(p);
  return p;
}

GradientProblem from_trial(const PublishedFiles& files) {
  const PublishedTrial trial = read_published(files);
  GradientProblem p;
  p.name = trial.name;
  p.model = trial.model;
  p.problem.positions = trial.tracking.problem.positions;
  finish(p);
  return p;
}

// Both sides go back and forth between two poses, or they could keep what they computed.
class Ours {
 public:
  explicit Ours(const GradientProblem& p)
      : p_(p), ws_(p.tree), J_(3, p.tree.unknown_count()), g_(p.tree.unknown_count()) {
    update_kinematics(p.tree, ws_);
  }
  void pose() {
    flip_ = !flip_;
    for (std::size_t x = 0; x < p_.tree.unknown_v.size(); ++x) {
      const auto q =
          static_cast<std::size_t>(p_.tree.q_of_v[static_cast<std::size_t>(p_.tree.unknown_v[x])]);
      ws_.q[q] = p_.tree.default_q[q] + (flip_ ? 0.1 : 0.2);
    }
    update_kinematics(p_.tree, ws_);
  }
  void decomposed() { decomposed_gradient(p_.tree, p_.problem, p_.targets, ws_, g_); }
  void by_jacobian() { jacobian_gradient(p_.tree, p_.problem, p_.targets, ws_, J_, g_); }

 private:
  const GradientProblem& p_;
  KinematicWorkspace ws_;
  Eigen::Matrix3Xd J_;
  Eigen::VectorXd g_;
  bool flip_ = false;
};

// Locks and couplers are left to the caller of Simbody's operator, who would have to fold them.
class Simbodys {
 public:
  explicit Simbodys(const GradientProblem& p)
      : p_(p),
        simbody_(p.model),
        state_(simbody_.default_state()),
        forces_(simbody_.matter().getNumBodies()) {
    pose();
  }
  void pose() {
    flip_ = !flip_;
    SimTK::Vector& q = state_.updQ();
    q = simbody_.default_state().getQ();
    q += flip_ ? 0.1 : 0.2;
    simbody_.system().realize(state_, SimTK::Stage::Position);
  }
  void gradient() {
    forces_ = SimTK::SpatialVec(SimTK::Vec3(0), SimTK::Vec3(0));
    for (std::size_t i = 0; i < p_.problem.positions.size(); ++i) {
      const PositionResidual& r = p_.problem.positions[i];
      const SimTK::MobilizedBody& body = simbody_.matter().getMobilizedBody(simbody_.body(r.link));
      const SimTK::Vec3 p_BP = to_simtk(r.p_BP);
      const SimTK::Vec3 pull = r.weight(0, 0) * (body.findStationLocationInGround(state_, p_BP) -
                                                 to_simtk(p_.targets.positions[i]));
      body.applyForceToBodyPoint(state_, p_BP, pull, forces_);
    }
    simbody_.matter().multiplyBySystemJacobianTranspose(state_, forces_, g_);
  }

 private:
  const GradientProblem& p_;
  SimbodyModel simbody_;
  SimTK::State state_;
  SimTK::Vector_<SimTK::SpatialVec> forces_;
  SimTK::Vector g_;
  bool flip_ = false;
};

void print_row(const GradientProblem& p, double batch_seconds) {
  Ours ours(p);
  Simbodys simbodys(p);
  const std::vector<double> s = best_seconds(
      {[&] {
         ours.pose();
         ours.decomposed();
       },
       [&] {
         ours.pose();
         ours.by_jacobian();
       },
       [&] {
         simbodys.pose();
         simbodys.gradient();
       },
       [&] { ours.decomposed(); }, [&] { ours.by_jacobian(); }, [&] { simbodys.gradient(); }},
      batch_seconds);
  fmt::print("| {:20} | {:5} | {:6} |", p.name, p.tree.unknown_count(), p.problem.positions.size());
  for (const std::size_t first : {std::size_t{0}, std::size_t{3}}) {
    fmt::print(" {:8.2f} | {:9.2f} | {:6.1f}x | {:8.2f} | {:6.1f}x |", 1e6 * s[first],
               1e6 * s[first + 1], s[first + 1] / s[first], 1e6 * s[first + 2],
               s[first + 2] / s[first]);
  }
  fmt::print("\n");
}

}  // namespace

void print_gradient_times(double batch_seconds) {
  fmt::print(
      "Gradient of marker residuals [us], with the kinematics of a new pose and without\n\n"
      "|                      |       |        | {:^49} | {:^49} |\n"
      "| model                |   DOF | points |      DGC |  Jacobian |   ratio |  Simbody |   "
      "ratio "
      "|      DGC |  Jacobian |   ratio |  Simbody |   ratio |\n"
      "| -------------------- | ----: | -----: | -------: | --------: | ------: | -------: | "
      "------: "
      "| -------: | --------: | ------: | -------: | ------: |\n",
      "with kinematics", "without");
  for (const PublishedFiles& files : published_files()) {
    if (is_present(files)) {
      print_row(from_trial(files), batch_seconds);
    } else {
      fmt::print("{}: no recordings, {} is missing\n", files.name,
                 (kPublishedData / files.model).string());
    }
  }
  for (const int links : {4, 40, 400}) print_row(chain(links), batch_seconds);
  for (const int links : {4, 40, 400}) print_row(bush(links), batch_seconds);
  fmt::print(
      "\nDGC: decomposed_gradient(). Jacobian: jacobian_gradient(), which visits only the links "
      "between\na point and the root. Simbody: forces on bodies and "
      "multiplyBySystemJacobianTranspose(), by speeds,\nwithout folding couplers; with kinematics: "
      "realize(Position). The ratios are to DGC.\n\n");
}

}  // namespace sinew
