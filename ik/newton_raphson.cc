#include "ik/newton_raphson.h"

#include <fmt/format.h>
#include <kinsol/kinsol.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_config.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <Eigen/QR>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <vector>

#include "ik/residual_rows.h"

namespace sinew {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// A pivot of J below this part of the largest is rounding of what should be zero.
constexpr double kRankThreshold = 1e-12;

// What SUNDIALS 7 renamed of 6.
#if SUNDIALS_VERSION_MAJOR >= 7
const SUNComm kAlone = SUN_COMM_NULL;
#else
void* const kAlone = nullptr;
#endif
constexpr int kDone = 0;  // SUNLS_SUCCESS, then SUN_SUCCESS

// SUNDIALS' objects, each freed in its own way.
struct Free {
  void operator()(SUNContext context) const { SUNContext_Free(&context); }
  void operator()(N_Vector vector) const { N_VDestroy(vector); }
  void operator()(SUNMatrix matrix) const { SUNMatDestroy(matrix); }
  void operator()(SUNLinearSolver solver) const { SUNLinSolFree(solver); }
  void operator()(void* kinsol) const { KINFree(&kinsol); }
};
template <typename Pointer>
using Owner = std::unique_ptr<std::remove_pointer_t<Pointer>, Free>;

Owner<SUNContext> make_context() {
  SUNContext context = nullptr;
  if (SUNContext_Create(kAlone, &context) != 0) throw std::bad_alloc();
  return Owner<SUNContext>(context);
}

template <typename Pointer>
Owner<Pointer> owned(Pointer pointer) {
  if (pointer == nullptr) throw std::bad_alloc();
  return Owner<Pointer>(pointer);
}

Eigen::Map<VectorXd> map(N_Vector v) { return {N_VGetArrayPointer(v), N_VGetLength(v)}; }

// Steps of least norm or least squares through the part of J that is in use.
struct LeastNormSolver {
  int rows = 0, columns = 0;  // of J in use; the rest is padding
  double step_norm = kNaN;    // of the last step
  MatrixXd J;
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> factors;

  static LeastNormSolver& of(SUNLinearSolver solver) {
    return *static_cast<LeastNormSolver*>(solver->content);
  }

  static int setup(SUNLinearSolver solver, SUNMatrix matrix) {
    LeastNormSolver& self = of(solver);
    const Eigen::Map<const MatrixXd> padded(
        SUNDenseMatrix_Data(matrix), SUNDenseMatrix_Rows(matrix), SUNDenseMatrix_Columns(matrix));
    self.J = padded.topLeftCorner(self.rows, self.columns);
    self.factors.setThreshold(kRankThreshold);
    self.factors.compute(self.J);
    return self.factors.rank() == std::min(self.rows, self.columns) ? kDone : SUNLS_QRFACT_FAIL;
  }

  static int solve(SUNLinearSolver solver, SUNMatrix, N_Vector x, N_Vector b, sunrealtype) {
    LeastNormSolver& self = of(solver);
    auto step = map(x).head(self.columns);
    map(x).setZero();
    step = self.factors.solve(map(b).head(self.rows));
    // KINSOL takes b for J x, the slope of its line search; so it is, but for least squares.
    map(b).head(self.rows) = self.J * step;
    self.step_norm = step.norm();
    return step.allFinite() ? kDone : SUNLS_QRSOL_FAIL;
  }
};

Owner<SUNLinearSolver> make_linear_solver(LeastNormSolver& content, SUNContext context) {
  Owner<SUNLinearSolver> solver = owned(SUNLinSolNewEmpty(context));
  solver->content = &content;
  solver->ops->gettype = [](SUNLinearSolver) { return SUNLINEARSOLVER_DIRECT; };
  solver->ops->getid = [](SUNLinearSolver) { return SUNLINEARSOLVER_CUSTOM; };
  solver->ops->setup = LeastNormSolver::setup;
  solver->ops->solve = LeastNormSolver::solve;
  solver->ops->free = [](SUNLinearSolver s) {
    SUNLinSolFreeEmpty(s);  // leaves the content, which is not its own
    return 0;
  };
  return solver;
}

std::string name_of(int flag) {
  char* name = KINGetReturnFlagName(flag);
  const std::string copy = name;
  std::free(name);
  return copy;
}

Termination termination_of(int flag) {
  switch (flag) {
    case KIN_SUCCESS:
    case KIN_INITIAL_GUESS_OK:
      return Termination::kSolved;
    case KIN_MAXITER_REACHED:
      return Termination::kMaxIterations;
    case KIN_LSETUP_FAIL:
    case KIN_LSOLVE_FAIL:
    case KIN_LINSOLV_NO_RECOVERY:
      return Termination::kSingular;
    case KIN_FIRST_SYSFUNC_ERR:
      return Termination::kNotFinite;
    default:
      return Termination::kDiverged;
  }
}

}  // namespace

void NewtonRaphson::Options::validate() const {
  const auto reject = [](const char* field, double value, const char* bound) {
    throw std::invalid_argument(
        fmt::format("NewtonRaphson::Options.{} is {}; expected {}", field, value, bound));
  };
  if (!(tolerance > 0.0)) reject("tolerance", tolerance, "more than 0");
  if (max_iterations < 1) reject("max_iterations", max_iterations, "1 or more");
  if (!(largest_step > 0.0)) reject("largest_step", largest_step, "more than 0");
}

// KINSOL's unknowns are u in q(u) = q₀ ⊞ u, which are the steps from the start q₀.
class NewtonRaphson::Kinsol {
 public:
  Kinsol(const KinematicTree& tree, const IkProblem& problem, const Options& options)
      : tree_(tree),
        problem_(problem),
        options_(options),
        workspace_(tree),
        q_start_(tree.default_q),
        rows_(tree, problem),
        g_(tree.unknown_count()),
        u_before_(tree.unknown_count()),
        size_(std::max({row_count(problem), tree.unknown_count(), 1})),
        context_(make_context()),
        u_(owned(N_VNew_Serial(size_, context_.get()))),
        scale_(owned(N_VClone(u_.get()))),
        J_(owned(SUNDenseMatrix(size_, size_, context_.get()))),
        linear_(make_linear_solver(least_norm_, context_.get())),
        kinsol_(owned(KINCreate(context_.get()))) {
    std::fill(tree_.lower.begin(), tree_.lower.end(), -HUGE_VAL);
    std::fill(tree_.upper.begin(), tree_.upper.end(), HUGE_VAL);
    N_VConst(1.0, scale_.get());
    void* k = kinsol_.get();
    hear_errors();
    check(KINSetUserData(k, this), "KINSetUserData");
    check(KINInit(k, equations, u_.get()), "KINInit");
    check(KINSetLinearSolver(k, linear_.get(), J_.get()), "KINSetLinearSolver");
    check(KINSetJacFn(k, jacobian), "KINSetJacFn");
    check(KINSetMaxSetupCalls(k, 1), "KINSetMaxSetupCalls");  // a new J every iteration
    check(KINSetNoResMon(k, SUNTRUE), "KINSetNoResMon");
    check(KINSetNumMaxIters(k, options.max_iterations), "KINSetNumMaxIters");
    check(KINSetFuncNormTol(k, options.tolerance), "KINSetFuncNormTol");
    // Steps below rounding go nowhere.
    check(KINSetScaledStepTol(k, std::numeric_limits<double>::epsilon()), "KINSetScaledStepTol");
    check(KINSetMaxNewtonStep(k, options.largest_step), "KINSetMaxNewtonStep");
  }

  const Summary& solve(const IkTargets& targets, std::span<double> q) {
    const auto start = std::chrono::steady_clock::now();
    targets_ = &targets;
    std::copy(q.begin(), q.end(), q_start_.begin());
    N_VConst(0.0, u_.get());
    summary_ = {};
    message_.clear();
    place(u_.get());
    rows_.update(tree_, problem_, targets, workspace_);
    least_norm_.rows = rows_.count;
    least_norm_.columns = tree_.unknown_count();
    summary_.initial_cost = cost(tree_, problem_, targets, workspace_);
    const int flag =
        KINSol(kinsol_.get(), u_.get(), options_.line_search ? KIN_LINESEARCH : KIN_NONE,
               scale_.get(), scale_.get());
    summary_.termination = termination_of(flag);
    summary_.detail = name_of(flag) + (message_.empty() ? "" : ": " + message_);
    long int iterations = 0, evaluations = 0;
    KINGetNumNonlinSolvIters(kinsol_.get(), &iterations);
    KINGetNumFuncEvals(kinsol_.get(), &evaluations);
    // KINSOL counts an iteration when it begins; a singular one made no step.
    summary_.iterations =
        static_cast<int>(iterations) - (summary_.termination == Termination::kSingular ? 1 : 0);
    summary_.evaluations = static_cast<int>(evaluations);
    place(u_.get());
    if (static_cast<int>(summary_.rows.size()) < summary_.iterations) record();
    measure();
    if (!options_.record_iterations) summary_.rows.clear();
    std::copy(workspace_.q.begin(), workspace_.q.end(), q.begin());
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    summary_.seconds = elapsed.count();
    return summary_;
  }

 private:
  static void check(int flag, const char* call) {
    if (flag != KIN_SUCCESS) {
      throw std::runtime_error(fmt::format("{} failed with {}", call, name_of(flag)));
    }
  }

#if SUNDIALS_VERSION_MAJOR >= 7
  void hear_errors() {
    SUNContext_ClearErrHandlers(context_.get());
    const auto remember = [](int, const char*, const char*, const char* message, SUNErrCode,
                             void* self,
                             SUNContext) { static_cast<Kinsol*>(self)->message_ = message; };
    check(SUNContext_PushErrHandler(context_.get(), remember, this), "SUNContext_PushErrHandler");
  }
#else
  void hear_errors() {
    const auto remember = [](int, const char*, const char*, char* message, void* self) {
      static_cast<Kinsol*>(self)->message_ = message;
    };
    check(KINSetErrHandlerFn(kinsol_.get(), remember, this), "KINSetErrHandlerFn");
  }
#endif

  // Kinematics of q(u).
  void place(N_Vector u) {
    const auto unknowns = static_cast<std::size_t>(tree_.unknown_count());
    advance(tree_, q_start_, {N_VGetArrayPointer(u), unknowns}, workspace_.q);
    update_kinematics(tree_, workspace_);
  }

  static int equations(N_Vector u, N_Vector e, void* self) {
    Kinsol& k = *static_cast<Kinsol*>(self);
    k.place(u);
    k.rows_.update(k.tree_, k.problem_, *k.targets_, k.workspace_);
    k.least_norm_.rows = k.rows_.count;
    map(e).setZero();
    map(e).head(k.rows_.count) = k.rows_.b.head(k.rows_.count);
    return map(e).allFinite() ? 0 : 1;  // 1: recoverable, KINSOL shortens the step
  }

  static int jacobian(N_Vector u, N_Vector, SUNMatrix J, void* self, N_Vector, N_Vector) {
    Kinsol& k = *static_cast<Kinsol*>(self);
    k.place(u);
    k.rows_.update(k.tree_, k.problem_, *k.targets_, k.workspace_);
    k.least_norm_.rows = k.rows_.count;
    if (k.is_after_a_step()) k.record();
    k.turn_columns(u);
    Eigen::Map<MatrixXd> padded(SUNDenseMatrix_Data(J), k.size_, k.size_);
    padded.topLeftCorner(k.rows_.count, k.rows_.A.cols()) = k.rows_.A.topRows(k.rows_.count);
    return 0;
  }

  // Columns of a joint that steps as a quaternion belong to its angular velocity ω; that of
  // exp(w) q is ω = J_l(w) ẇ with J_l = K_γ(w)⁻ᵀ.
  void turn_columns(N_Vector u) {
    for (const KinematicTree::Link& link : tree_.links) {
      using Kind = KinematicTree::Kind;
      if (link.kind != Kind::kBall && link.kind != Kind::kFree) continue;
      const int x = tree_.unknown_of_v[static_cast<std::size_t>(link.first_v)];
      const Eigen::Vector3d w = map(u).segment<3>(x);
      const Eigen::Matrix3d J_l = rotation_vector_rate(w).transpose().inverse();
      rows_.A.middleCols<3>(x) = (rows_.A.middleCols<3>(x) * J_l).eval();
    }
  }

  // The first Jacobian is that of the start.
  bool is_after_a_step() {
    if (std::isnan(summary_.final_cost)) {
      summary_.final_cost = summary_.initial_cost;
      u_before_.setZero();
      return false;
    }
    return true;
  }

  void record() {
    measure();
    const VectorXd u = map(u_.get()).head(u_before_.size());
    const double step = (u - u_before_).norm();
    u_before_ = u;
    const int iteration = static_cast<int>(summary_.rows.size()) + 1;
    summary_.rows.push_back({iteration, summary_.final_cost, summary_.gradient_norm,
                             step / least_norm_.step_norm, step});
  }

  void measure() {
    summary_.final_cost = decomposed_gradient(tree_, problem_, *targets_, workspace_, g_);
    summary_.gradient_norm = g_.size() > 0 ? g_.cwiseAbs().maxCoeff() : 0.0;
    summary_.held = 0;
  }

  KinematicTree tree_;  // without bounds
  const IkProblem& problem_;
  Options options_;
  KinematicWorkspace workspace_;
  std::vector<double> q_start_;
  ResidualRows rows_;
  VectorXd g_, u_before_;
  const IkTargets* targets_ = nullptr;
  Summary summary_;
  std::string message_;
  LeastNormSolver least_norm_;
  sunindextype size_;  // of KINSOL's system, padded
  Owner<SUNContext> context_;
  Owner<N_Vector> u_, scale_;
  Owner<SUNMatrix> J_;
  Owner<SUNLinearSolver> linear_;
  Owner<void*> kinsol_;
};

NewtonRaphson::NewtonRaphson(const KinematicTree& tree, const IkProblem& problem,
                             const Options& options) {
  options.validate();
  kinsol_ = std::make_unique<Kinsol>(tree, problem, options);
}

NewtonRaphson::~NewtonRaphson() = default;

const Summary& NewtonRaphson::solve(const IkTargets& targets, std::span<double> q) {
  return kinsol_->solve(targets, q);
}

}  // namespace sinew
