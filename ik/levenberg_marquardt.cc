#include "ik/levenberg_marquardt.h"

#include <Eigen/Cholesky>

namespace sinew {
namespace {

bool choose_dual(LevenbergMarquardt::Form form, int rows, int unknowns) {
  using enum LevenbergMarquardt::Form;
  return form == kDual || (form == kSmaller && rows < unknowns);
}

int size_of(bool dual, const KinematicTree& tree, const IkProblem& problem) {
  return dual ? row_count(problem) : tree.unknown_count();
}

}  // namespace

LevenbergMarquardt::LevenbergMarquardt(const KinematicTree& tree, const IkProblem& problem,
                                       const Options& options)
    : options_(options),
      dual_(choose_dual(options.form, row_count(problem), tree.unknown_count())),
      curvature_(tree, problem),
      rows_(tree, dual_ ? problem : IkProblem{}),
      matrix_(size_of(dual_, tree, problem), size_of(dual_, tree, problem)),
      solution_(dual_ ? row_count(problem) : 0) {}

bool LevenbergMarquardt::compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) {
  return (dual_ ? dual(at, d) : primal(at, d)) && d.dot(at.g) < 0.0;
}

bool LevenbergMarquardt::primal(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) {
  curvature_.update(at.tree, at.problem, *at.targets, at.workspace);
  curvature_.matrix(at.problem, *at.targets, at.workspace, matrix_);  // (32)
  matrix_.diagonal().array() += at.f + options_.lambda;
  for (Eigen::Index x = 0; x < matrix_.rows(); ++x) {
    if (!at.held[static_cast<std::size_t>(x)]) continue;
    matrix_.row(x).setZero();
    matrix_.col(x).setZero();
    matrix_(x, x) = 1.0;
  }
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(matrix_);  // in place
  if (llt.info() != Eigen::Success) return false;
  d = -at.g;  // (31)
  llt.solveInPlace(d);
  return true;
}

bool LevenbergMarquardt::dual(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) {
  rows_.update(at.tree, at.problem, *at.targets, at.workspace);
  for (Eigen::Index x = 0; x < d.size(); ++x) {
    if (at.held[static_cast<std::size_t>(x)]) rows_.A.col(x).setZero();
  }
  const int m = rows_.count;
  const auto A = rows_.A.topRows(m);
  auto matrix = matrix_.topLeftCorner(m, m);
  matrix.setZero();
  matrix.selfadjointView<Eigen::Lower>().rankUpdate(A);
  matrix.diagonal().array() += at.f + options_.lambda;
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(matrix);  // in place
  if (llt.info() != Eigen::Success) return false;
  auto z = solution_.head(m);
  z = rows_.b.head(m);
  llt.solveInPlace(z);
  d.noalias() = -A.transpose() * z;
  return true;
}

}  // namespace sinew
