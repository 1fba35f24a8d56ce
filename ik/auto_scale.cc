#include "ik/auto_scale.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <stdexcept>

#include "ik/auto_scale_parameters.h"
#include "ik/auto_scale_samples.h"
#include "ik/box_quadratic.h"
#include "ik/distance_sizes.h"
#include "ik/residual_rows.h"
#include "ik/tracking.h"

namespace sinew {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// One frame of one sample, and its pose, from which the next search starts.
struct Frame {
  std::size_t sample = 0;
  int index = 0;
  std::vector<double> q;
};

class AutoScaler {
 public:
  AutoScaler(const MusculoskeletalModel& model, const std::vector<AutoScaleTrial>& trials,
             const AutoScaleOptions& options)
      : model_(model), options_(options), result_(model) {
    for (const AutoScaleTrial& trial : trials) samples_.push_back(take_frames(trial, options));
  }

  AutoScaleResult run();

 private:
  void start();
  std::vector<Frame> find_poses(const CompiledSamples& compiled) const;
  bool look_again();
  std::vector<int> tracked_markers(const CompiledSamples& compiled) const;
  double fit_poses(const CompiledSamples& compiled, std::vector<Frame>& frames) const;
  double prior(const VectorXd& theta) const { return 0.5 * theta.dot(precision_ * theta); }
  void linearize(const CompiledSamples& compiled, const VectorXd& theta);
  MatrixXd frame_jacobian(const std::vector<CompiledSamples>& perturbed,
                          const CompiledSamples& compiled, const Frame& frame,
                          const VectorXd& theta, ResidualRows& rows) const;
  void add_frame(const CompiledSamples& compiled, const Frame& frame, const ResidualRows& rows,
                 const MatrixXd& J);
  bool step();
  void iterate();
  // body(marker, X_WB of its body, measured less where the model has it in ground [m]) of every
  // measured marker in the frames, or in those of a sample.
  template <typename Body>
  void for_each_error(const CompiledSamples& compiled, const std::vector<Frame>& frames,
                      std::optional<std::size_t> of_sample, const Body& body) const;
  double rms(const CompiledSamples& compiled, const std::vector<Frame>& frames,
             std::optional<std::size_t> of_sample = {}) const;
  RowMatrix mean_residuals(const CompiledSamples& compiled, std::size_t sample) const;
  void finish();
  void describe();
  void name_limits();

  template <typename Body>
  void parallel(std::size_t count, const Body& body) const {
    const int threads = options_.threads == 0 ? tbb::info::default_concurrency() : options_.threads;
    const tbb::global_control allowed(
        tbb::global_control::max_allowed_parallelism,
        static_cast<std::size_t>(std::max(threads, tbb::info::default_concurrency())));
    tbb::task_arena arena(threads);
    arena.execute([&] { tbb::parallel_for(std::size_t{0}, count, body); });
  }

  const MusculoskeletalModel& model_;
  const AutoScaleOptions& options_;
  std::vector<FrameSample> samples_;
  std::vector<Frame> frames_;
  AutoScaleParameters parameters_;
  VectorXd theta_;
  MatrixXd precision_;  // P⁻¹
  MatrixXd N_;          // curvature of the data's part
  VectorXd g_;          // gradient of F
  double F_ = kNaN;
  AutoScaleResult result_;
};

std::vector<int> AutoScaler::tracked_markers(const CompiledSamples& compiled) const {
  std::set<int> tracked;
  for (const TrackingProblem& problem : compiled.problems) {
    for (const TrackedMarker& marker : problem.markers) tracked.insert(marker.model);
  }
  return {tracked.begin(), tracked.end()};
}

// Sizes by distances between markers, and the poses of a model of these.
void AutoScaler::start() {
  const CompiledSamples bare(model_, samples_, options_.name_unmatched);
  for (std::size_t s = 0; s < samples_.size(); ++s) {
    const TrackingProblem& problem = bare.problems[s];
    result_.warnings.insert(result_.warnings.end(), problem.warnings.begin(),
                            problem.warnings.end());
    samples_[s].tasks = posture_tasks(bare, s, samples_[s].file.markers, options_);
  }
  parameters_ = choose_parameters(model_, tracked_markers(bare), options_);
  precision_ = parameters_.prior_precision();
  theta_ = sizes_from_distances(model_, parameters_, samples_, options_);
  const CompiledSamples rough(parameters_.apply(model_, theta_), samples_);
  frames_ = find_poses(rough);
  result_.frames = static_cast<int>(frames_.size());
  const CompiledSamples before(model_, samples_);
  std::vector<Frame> frames = frames_;
  fit_poses(before, frames);
  result_.rms_before = rms(before, frames);
  F_ = fit_poses(rough, frames_) + prior(theta_);
}

// The poses of all frames in which something is measured, looked for without knowing any.
std::vector<Frame> AutoScaler::find_poses(const CompiledSamples& compiled) const {
  std::vector<Frame> frames;
  TrackingOptions tracking;
  tracking.minimizer = options_.minimizer;
  tracking.threads = options_.threads;
  tracking.cold_start = options_.cold_start;
  tracking.unrelated_frames = true;
  for (std::size_t s = 0; s < samples_.size(); ++s) {
    const TrackingResult poses = track(compiled.model, compiled.tree, compiled.problems[s],
                                       samples_[s].file.markers, tracking);
    for (int i = 0; i < static_cast<int>(poses.frames.size()); ++i) {
      Frame frame{s, i, compiled.tree.default_q};
      for (std::size_t c = 0; c < compiled.tree.q_of_coordinate.size(); ++c) {
        frame.q[static_cast<std::size_t>(compiled.tree.q_of_coordinate[c])] =
            poses.coordinates(i, static_cast<Eigen::Index>(c));
      }
      if (poses.frames[static_cast<std::size_t>(i)].measured_markers > 0) frames.push_back(frame);
    }
  }
  return frames;
}

// Whether poses that are looked for anew, now that sizes are known, lie lower. They are taken then.
bool AutoScaler::look_again() {
  const CompiledSamples compiled(parameters_.apply(model_, theta_), samples_);
  std::vector<Frame> frames = find_poses(compiled);
  if (frames.size() != frames_.size()) return false;
  const double F = fit_poses(compiled, frames) + prior(theta_);
  constexpr double kWorthIt = 1e-3;  // below it sizes hardly change
  if (!(F < (1.0 - kWorthIt) * F_)) return false;
  F_ = F;
  frames_ = std::move(frames);
  return true;
}

// The data's part of F; each frame's pose is searched from where it was. Frames are summed in their
// order, so that the sum does not depend on the threads.
double AutoScaler::fit_poses(const CompiledSamples& compiled, std::vector<Frame>& frames) const {
  std::vector<double> costs(frames.size());
  constexpr std::size_t kBlock = 8;  // frames that share a solver
  parallel((frames.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
    std::optional<Minimizer> minimizer;
    std::size_t bound = samples_.size();  // the sample that the solver is for
    for (std::size_t i = block * kBlock; i < std::min(frames.size(), (block + 1) * kBlock); ++i) {
      Frame& frame = frames[i];
      const TrackingProblem& problem = compiled.problems[frame.sample];
      const MarkerTrajectories& markers = samples_[frame.sample].file.markers;
      if (bound != frame.sample) {
        minimizer.emplace(compiled.tree, problem.problem, options_.minimizer);
        bound = frame.sample;
      }
      IkTargets targets(problem.problem);
      set_targets(problem, markers, frame.index, targets);
      prescribe(compiled.tree, markers.time[frame.index], frame.q);
      costs[i] = samples_[frame.sample].weight * minimizer->minimize(targets, frame.q).final_cost;
    }
  });
  double sum = 0.0;
  for (const double cost : costs) sum += cost;
  return sum;
}

template <typename Body>
void AutoScaler::for_each_error(const CompiledSamples& compiled, const std::vector<Frame>& frames,
                                std::optional<std::size_t> of_sample, const Body& body) const {
  KinematicWorkspace ws(compiled.tree);
  for (const Frame& frame : frames) {
    if (of_sample && *of_sample != frame.sample) continue;
    std::copy(frame.q.begin(), frame.q.end(), ws.q.begin());
    update_poses(compiled.tree, ws);
    const TrackingProblem& problem = compiled.problems[frame.sample];
    for (std::size_t i = 0; i < problem.markers.size(); ++i) {
      const PositionResidual& r = problem.problem.positions[i];
      const RigidTransform& X_WB = ws.X_WB[static_cast<std::size_t>(r.link)];
      const Eigen::Vector3d error =
          samples_[frame.sample].file.markers.position(frame.index, problem.markers[i].recorded) -
          X_WB * r.p_BP;
      if (error.allFinite()) body(problem.markers[i], X_WB, error);
    }
  }
}

double AutoScaler::rms(const CompiledSamples& compiled, const std::vector<Frame>& frames,
                       std::optional<std::size_t> of_sample) const {
  double sum = 0.0;
  int count = 0;
  for_each_error(compiled, frames, of_sample,
                 [&](const TrackedMarker&, const RigidTransform&, const Eigen::Vector3d& error) {
                   sum += error.squaredNorm();
                   ++count;
                 });
  return std::sqrt(sum / count);
}

RowMatrix AutoScaler::mean_residuals(const CompiledSamples& compiled, std::size_t sample) const {
  const auto n = static_cast<Eigen::Index>(compiled.model.markers.size());
  RowMatrix sums = RowMatrix::Zero(n, 3);
  VectorXd counts = VectorXd::Zero(n);
  for_each_error(
      compiled, frames_, sample,
      [&](const TrackedMarker& marker, const RigidTransform& X_WB, const Eigen::Vector3d& error) {
        sums.row(marker.model) += (X_WB.R.transpose() * error).transpose();
        counts[marker.model] += 1.0;
      });
  return sums.array().colwise() / counts.array();  // 0/0 where nothing is measured
}

// ∂b/∂θ of one frame. Residuals are linear in the factors at a given pose, so differences with the
// factor raised by 1 are exact, and ∂/∂log f = f ∂/∂f.
MatrixXd AutoScaler::frame_jacobian(const std::vector<CompiledSamples>& perturbed,
                                    const CompiledSamples& compiled, const Frame& frame,
                                    const VectorXd& theta, ResidualRows& rows) const {
  const TrackingProblem& tracking = compiled.problems[frame.sample];
  const MarkerTrajectories& markers = samples_[frame.sample].file.markers;
  IkTargets targets(tracking.problem);
  set_targets(tracking, markers, frame.index, targets);
  KinematicWorkspace ws(compiled.tree);
  std::copy(frame.q.begin(), frame.q.end(), ws.q.begin());
  update_kinematics(compiled.tree, ws);
  rows.update(compiled.tree, tracking.problem, targets, ws);
  MatrixXd J = MatrixXd::Zero(rows.count, parameters_.count());
  ResidualRows raised(compiled.tree, tracking.problem);
  KinematicWorkspace raised_ws(compiled.tree);
  for (int k = 0; k < parameters_.factor_count(); ++k) {
    const CompiledSamples& other = perturbed[static_cast<std::size_t>(k)];
    std::copy(frame.q.begin(), frame.q.end(), raised_ws.q.begin());
    update_kinematics(other.tree, raised_ws);
    raised.update(other.tree, other.problems[frame.sample].problem, targets, raised_ws);
    J.col(AutoScaleParameters::deviation_of(k)) =
        std::exp(parameters_.log_factor(theta, k)) *
        (raised.b.head(rows.count) - rows.b.head(rows.count));
  }
  // The body's size raises all of them.
  J.col(0) = J.middleCols(1, parameters_.factor_count()).rowwise().sum();
  // Position rows come first, three a measured marker, with weight 1.
  int row = 0;
  for (std::size_t i = 0; i < tracking.markers.size(); ++i) {
    if (std::isnan(targets.positions[i].x())) continue;
    const auto free = std::find(parameters_.free_markers.begin(), parameters_.free_markers.end(),
                                tracking.markers[i].model);
    if (free != parameters_.free_markers.end()) {
      const auto at = static_cast<std::size_t>(free - parameters_.free_markers.begin());
      J.block<3, 3>(row, parameters_.offset_of(at)) =
          -ws.X_WB[static_cast<std::size_t>(tracking.problem.positions[i].link)].R;
    }
    row += 3;
  }
  return J;
}

// The pose is eliminated: Jᵀ(E − A A⁺)J, A the Jacobian of the unknowns that no bound holds.
void AutoScaler::add_frame(const CompiledSamples& compiled, const Frame& frame,
                           const ResidualRows& rows, const MatrixXd& J) {
  const KinematicTree& tree = compiled.tree;
  std::vector<int> free;
  for (int x = 0; x < tree.unknown_count(); ++x) {
    const auto i = static_cast<std::size_t>(x);
    const int q = tree.q_of_v[static_cast<std::size_t>(tree.unknown_v[i])];
    const double value = q < 0 ? 0.0 : frame.q[static_cast<std::size_t>(q)];
    if (value > tree.lower[i] && value < tree.upper[i]) free.push_back(x);
  }
  const MatrixXd A = rows.A.topRows(rows.count)(Eigen::all, free);
  // What no marker of this frame determines gets a curvature of 1e-9 of the largest, and so takes
  // no part.
  MatrixXd H = A.transpose() * A;
  if (H.size() > 0) H.diagonal().array() += 1e-9 * H.diagonal().maxCoeff();
  const MatrixXd AJ = A.transpose() * J;
  const double weight = samples_[frame.sample].weight;
  N_ += weight * (J.transpose() * J - AJ.transpose() * H.ldlt().solve(AJ));
  g_ += weight * (J.transpose() * rows.b.head(rows.count));
}

void AutoScaler::linearize(const CompiledSamples& compiled, const VectorXd& theta) {
  const int k = parameters_.factor_count();
  std::vector<CompiledSamples> perturbed;
  perturbed.reserve(static_cast<std::size_t>(k));
  for (int i = 0; i < k; ++i) {
    VectorXd raised = theta;
    raised[AutoScaleParameters::deviation_of(i)] =
        std::log(std::exp(parameters_.log_factor(theta, i)) + 1.0) - theta[0];
    perturbed.emplace_back(parameters_.apply(model_, raised), samples_);
  }
  N_ = MatrixXd::Zero(parameters_.count(), parameters_.count());
  g_ = precision_ * theta;
  // Blocks bound the memory; their frames are added in order, whatever thread made them.
  constexpr std::size_t kBlock = 16;
  for (std::size_t begin = 0; begin < frames_.size(); begin += kBlock) {
    const std::size_t count = std::min(kBlock, frames_.size() - begin);
    std::vector<MatrixXd> J(count);
    std::vector<ResidualRows> rows;
    for (std::size_t i = 0; i < count; ++i) {
      rows.emplace_back(compiled.tree, compiled.problems[frames_[begin + i].sample].problem);
    }
    parallel(count, [&](std::size_t i) {
      J[i] = frame_jacobian(perturbed, compiled, frames_[begin + i], theta, rows[i]);
    });
    for (std::size_t i = 0; i < count; ++i) {
      add_frame(compiled, frames_[begin + i], rows[i], J[i]);
    }
  }
}

// One Gauss-Newton step within the limits, halved until F falls; false at the end.
bool AutoScaler::step() {
  const CompiledSamples compiled(parameters_.apply(model_, theta_), samples_);
  linearize(compiled, theta_);
  const VectorXd full =
      minimize_in_box(N_ + precision_, g_, parameters_.lower - theta_, parameters_.upper - theta_);
  const int k = parameters_.factor_count();
  constexpr int kHalvings = 12;
  double length = 1.0;
  for (int i = 0; i < kHalvings; ++i, length *= 0.5) {
    // Rounding must not carry it over a limit.
    const VectorXd trial =
        (theta_ + length * full).cwiseMax(parameters_.lower).cwiseMin(parameters_.upper);
    std::vector<Frame> frames = frames_;
    const CompiledSamples there(parameters_.apply(model_, trial), samples_);
    const double F = fit_poses(there, frames) + prior(trial);
    if (!(F < F_)) continue;
    const VectorXd taken = trial - theta_;
    theta_ = trial;
    F_ = F;
    frames_ = std::move(frames);
    const auto factors = taken.segment(1, k).array() + taken[0];
    const auto offsets = taken.tail(taken.size() - 1 - k);
    result_.converged =
        factors.abs().maxCoeff() < options_.tolerance &&
        (offsets.size() == 0 || offsets.cwiseAbs().maxCoeff() <= options_.offset_tolerance);
    return !result_.converged;
  }
  // Nothing on the way lowers F: the limit of rounding, if the promised gain is that small.
  constexpr double kRounding = 1e-8;
  result_.converged = std::abs(g_.dot(full)) < kRounding * std::max(1.0, F_);
  return false;
}

void AutoScaler::iterate() {
  for (bool more = true; more && result_.iterations < options_.max_iterations;
       ++result_.iterations) {
    if (options_.progress && !options_.progress(result_.iterations, options_.max_iterations)) {
      result_.stopped = true;
      return;
    }
    more = step();
  }
}

AutoScaleResult AutoScaler::run() {
  const auto began = std::chrono::steady_clock::now();
  start();
  result_.iterations = 0;
  // Each look finds a lower minimum or ends it; no recording has needed more than two.
  constexpr int kLooks = 4;
  for (int look = 0; look < kLooks && !result_.stopped; ++look) {
    iterate();
    if (result_.stopped || !look_again()) break;
  }
  finish();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - began;
  result_.seconds = elapsed.count();
  return std::move(result_);
}

void AutoScaler::finish() {
  result_.factors = parameters_.scale_factors(model_, theta_);
  result_.size = std::exp(theta_[0]);
  const CompiledSamples compiled(parameters_.apply(model_, theta_), samples_);
  result_.markers = compiled.model.markers;
  result_.cost = F_;
  result_.rms_after = rms(compiled, frames_);
  for (std::size_t s = 0; s < samples_.size(); ++s) {
    const auto count = std::count_if(frames_.begin(), frames_.end(),
                                     [&](const Frame& frame) { return frame.sample == s; });
    result_.trials.push_back({static_cast<int>(count), samples_[s].poses, rms(compiled, frames_, s),
                              mean_residuals(compiled, s)});
  }
  linearize(compiled, theta_);
  describe();
  name_limits();
  VectorXd scaled_only = theta_;
  scaled_only.tail(theta_.size() - 1 - parameters_.factor_count()).setZero();
  const CompiledSamples unmoved(parameters_.apply(model_, scaled_only), samples_);
  fit_poses(unmoved, frames_);
  result_.rms_scaled = rms(unmoved, frames_);
}

void AutoScaler::describe() {
  const auto n = static_cast<Eigen::Index>(parameters_.count());
  const int k = parameters_.factor_count();
  const MatrixXd covariance = (N_ + precision_).ldlt().solve(MatrixXd::Identity(n, n));
  const MatrixXd prior_of_factors =
      parameters_.prior_covariance_of_factors.llt().solve(MatrixXd::Identity(k, k));
  const auto held = [&](Eigen::Index i) {
    return theta_[i] <= parameters_.lower[i] || theta_[i] >= parameters_.upper[i];
  };
  for (int i = 0; i < k; ++i) {
    const AutoScaleParameters::Factor& factor = parameters_.factors[static_cast<std::size_t>(i)];
    const int at = AutoScaleParameters::deviation_of(i);
    ScaleEstimate estimate;
    estimate.name = factor.name;
    estimate.bodies = factor.bodies;
    estimate.axis = factor.axis;
    estimate.factor = std::exp(parameters_.log_factor(theta_, i));
    estimate.prior_sd = std::sqrt(parameters_.prior_covariance_of_factors(i, i));
    estimate.open_sd = 1.0 / std::sqrt(prior_of_factors(i, i));
    estimate.posterior_sd =
        std::sqrt(covariance(0, 0) + 2.0 * covariance(0, at) + covariance(at, at));
    estimate.determinate = estimate.posterior_sd < 0.5 * estimate.open_sd;
    estimate.at_limit = held(at);
    result_.estimates.push_back(std::move(estimate));
  }
  for (std::size_t i = 0; i < parameters_.free_markers.size(); ++i) {
    const int at = parameters_.offset_of(i);
    result_.offsets.push_back({parameters_.free_markers[i], theta_.segment<3>(at),
                               covariance.diagonal().segment<3>(at).cwiseSqrt(),
                               held(at) || held(at + 1) || held(at + 2)});
  }
}

void AutoScaler::name_limits() {
  const SizeLimits& limits = options_.limits;
  std::vector<VerdictReason>& reasons = result_.reasons;
  if (theta_[0] <= parameters_.lower[0] || theta_[0] >= parameters_.upper[0]) {
    reasons.push_back(whole_size_reason(result_.size, limits));
  }
  for (const ScaleEstimate& estimate : result_.estimates) {
    if (!estimate.at_limit) continue;
    const std::string& body = model_.bodies[static_cast<std::size_t>(estimate.bodies[0])].name;
    reasons.push_back(
        segment_size_reason(body, estimate.axis, estimate.factor / result_.size, limits));
  }
  for (const MarkerOffset& offset : result_.offsets) {
    if (!offset.at_limit) continue;
    const std::string& name = model_.markers[static_cast<std::size_t>(offset.marker)].name;
    reasons.push_back(moved_marker_reason(name, offset.offset.cwiseAbs().maxCoeff(),
                                          options_.technical_markers, limits));
  }
}

}  // namespace

void AutoScaleOptions::validate() const {
  minimizer.validate();
  cold_start.validate();
  limits.validate();
  const auto require = [](bool good, const char* field, double value, const char* bound) {
    if (good) return;
    throw std::invalid_argument(
        fmt::format("AutoScaleOptions.{} is {}; expected {}", field, value, bound));
  };
  const auto positive = [&](const char* field, double value) {
    require(value > 0.0 && std::isfinite(value), field, value, "a finite number above 0");
  };
  positive("size_sd", size_sd);
  positive("segment_sd", segment_sd);
  positive("axis_sd", axis_sd);
  positive("marker_offset_sd", marker_offset_sd);
  positive("technical_marker_sd", technical_marker_sd);
  positive("posture_sd", posture_sd);
  positive("marker_sd", marker_sd);
  positive("independent_frames", independent_frames);
  positive("tolerance", tolerance);
  positive("offset_tolerance", offset_tolerance);
  require(frames >= 1, "frames", frames, "1 or more");
  require(max_iterations >= 1, "max_iterations", max_iterations, "1 or more");
  require(threads >= 0, "threads", threads, "0 or more");
}

AutoScaleResult auto_scale(const MusculoskeletalModel& model,
                           const std::vector<AutoScaleTrial>& trials,
                           const AutoScaleOptions& options) {
  options.validate();
  if (trials.empty()) throw std::invalid_argument("auto_scale: no trials; expected 1 or more");
  return AutoScaler(model, trials, options).run();
}

}  // namespace sinew
