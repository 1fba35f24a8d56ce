#include "dynamics/inverse_dynamics.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

#include "data/butterworth.h"
#include "dynamics/custom_joint_correction.h"

namespace sinew {
namespace {

// Times printed with 8 decimals are off by up to 5e-9 s, a millionth of a 5 ms step; sums of such
// steps over a minute by less than a thousandth.
constexpr double kRangeSlack = 1e-3;
// Frames a task takes at once: some 0.1 ms of work, against 1 µs to start a task.
constexpr int kGrain = 4;
// Frames between two reports of progress: a few milliseconds.
constexpr int kReportEvery = 64;

struct CompiledCoupler {
  std::size_t dependent, independent;
  CompiledFunction function;
};

// A coupler stands after the coupler that moves its independent coordinate, if there is one.
std::vector<CompiledCoupler> ordered_couplers(const MusculoskeletalModel& model) {
  std::vector<CompiledCoupler> ordered;
  std::vector<bool> waits(model.coordinates.size(), false);
  for (const CoordinateCoupler& c : model.couplers) {
    waits[static_cast<std::size_t>(c.dependent)] = true;
  }
  while (ordered.size() < model.couplers.size()) {
    const std::size_t before = ordered.size();
    for (const CoordinateCoupler& c : model.couplers) {
      const auto dependent = static_cast<std::size_t>(c.dependent);
      const auto independent = static_cast<std::size_t>(c.independent);
      if (!waits[dependent] || waits[independent]) continue;
      ordered.push_back({dependent, independent, CompiledFunction(c.function)});
      waits[dependent] = false;
    }
    if (ordered.size() == before) {
      throw std::invalid_argument("the model's couplers depend on each other in a circle");
    }
  }
  return ordered;
}

// All that a frame needs; one for each worker.
struct Workspace {
  SimTK::State state;
  SimTK::Vector q_dot, q_ddot, u, u_dot, n_dot_u;     // in the State's order
  SimTK::Vector no_mobility_forces, residual, tau_q;  // "
  SimTK::Vector_<SimTK::SpatialVec> F_B_W;            // by mobilized body
  std::vector<SimTK::SpatialVec> errors;              // by body, see CustomJointCorrection
  std::vector<double> q, v, a, tau;                   // by coordinate

  explicit Workspace(const SimbodyModel& compiled)
      : state(compiled.default_state()),
        q_dot(state.getNQ(), 0.0),
        q_ddot(state.getNQ(), 0.0),
        u(state.getNU(), 0.0),
        u_dot(state.getNU(), 0.0),
        n_dot_u(state.getNQ(), 0.0),
        no_mobility_forces(state.getNU(), 0.0),
        residual(state.getNU(), 0.0),
        tau_q(state.getNQ(), 0.0),
        F_B_W(compiled.matter().getNumBodies()),
        errors(static_cast<std::size_t>(compiled.body_count())),
        q(static_cast<std::size_t>(compiled.coordinate_count())),
        v(q.size()),
        a(q.size()),
        tau(q.size()) {}
};

class Solver {
 public:
  Solver(const MusculoskeletalModel& model, const SimbodyModel& compiled,
         const CoordinateSpline& motion, const ExternalLoads& loads,
         const InverseDynamicsOptions& options)
      : model_(model), compiled_(compiled), motion_(motion), loads_(loads) {
    if (options.project_couplers) couplers_ = ordered_couplers(model);
    if (options.exact_custom_joints) correction_.emplace(model, compiled);
  }

  const std::vector<CompiledCoupler>& couplers() const { return couplers_; }

  // Equations (1) and (2) of the header; leaves tau by coordinate in the workspace.
  void solve(double t, Workspace& w) const {
    motion_.evaluate(t, w.q, w.v, w.a);
    couple_motion(w);
    realize(t, w);
    w.F_B_W.setToZero();
    add_gravity(w);
    loads_.add_body_forces(t, compiled_, w.state, w.F_B_W);
    if (correction_) correction_->add_body_forces(w.q, w.v, w.state, w.errors, w.F_B_W);
    const SimTK::SimbodyMatterSubsystem& matter = compiled_.matter();
    matter.calcResidualForceIgnoringConstraints(w.state, w.no_mobility_forces, w.F_B_W, w.u_dot,
                                                w.residual);
    matter.multiplyByNInv(w.state, true, w.residual, w.tau_q);
    for (std::size_t c = 0; c < w.tau.size(); ++c) {
      w.tau[c] = w.tau_q[compiled_.q_index(static_cast<int>(c))];
    }
    fold_forces(w);
  }

 private:
  // q_d = f(q_i), q̇_d = f' q̇_i, q̈_d = f'' q̇_i² + f' q̈_i.
  void couple_motion(Workspace& w) const {
    for (const CompiledCoupler& c : couplers_) {
      const auto f = c.function.evaluate(w.q[c.independent]);
      const double rate = w.v[c.independent];
      w.q[c.dependent] = f.f;
      w.v[c.dependent] = f.df * rate;
      w.a[c.dependent] = f.ddf * rate * rate + f.df * w.a[c.independent];
    }
  }

  // Virtual work: tau_d δq_d = tau_d f' δq_i; the last coupler first, so that chains add up.
  void fold_forces(Workspace& w) const {
    for (auto c = couplers_.rbegin(); c != couplers_.rend(); ++c) {
      w.tau[c->independent] += c->function.evaluate(w.q[c->independent]).df * w.tau[c->dependent];
    }
  }

  void realize(double t, Workspace& w) const {
    const SimTK::SimbodyMatterSubsystem& matter = compiled_.matter();
    for (std::size_t c = 0; c < w.v.size(); ++c) {
      const int i = compiled_.q_index(static_cast<int>(c));
      w.q_dot[i] = w.v[c];
      w.q_ddot[i] = w.a[c];
    }
    w.state.setTime(t);
    compiled_.set_q(w.state, w.q);
    compiled_.system().realize(w.state, SimTK::Stage::Position);
    matter.multiplyByNInv(w.state, false, w.q_dot, w.u);
    w.state.updU() = w.u;
    compiled_.system().realize(w.state, SimTK::Stage::Velocity);
    matter.multiplyByNDot(w.state, false, w.u, w.n_dot_u);
    for (int i = 0; i < w.q_ddot.size(); ++i) w.q_ddot[i] -= w.n_dot_u[i];
    matter.multiplyByNInv(w.state, false, w.q_ddot, w.u_dot);
  }

  void add_gravity(Workspace& w) const {
    const SimTK::SimbodyMatterSubsystem& matter = compiled_.matter();
    for (std::size_t b = 1; b < model_.bodies.size(); ++b) {
      const Body& body = model_.bodies[b];
      const SimTK::MobilizedBodyIndex index = compiled_.body(static_cast<int>(b));
      const SimTK::Rotation& R_WB = matter.getMobilizedBody(index).getBodyRotation(w.state);
      const SimTK::Vec3 weight = body.mass * to_simtk(model_.gravity);
      w.F_B_W[index] += SimTK::SpatialVec((R_WB * to_simtk(body.p_BCm)) % weight, weight);
    }
  }

  const MusculoskeletalModel& model_;
  const SimbodyModel& compiled_;
  const CoordinateSpline& motion_;
  const ExternalLoads& loads_;
  std::optional<CustomJointCorrection> correction_;
  std::vector<CompiledCoupler> couplers_;
};

// Reports progress from any thread, one at a time, and remembers a request to stop.
class Progress {
 public:
  Progress(const InverseDynamicsOptions& options, int total) : options_(options), total_(total) {}
  void frame_done() {
    const int done = ++done_;
    if (!options_.progress || (done % kReportEvery != 0 && done != total_)) return;
    const std::lock_guard lock(mutex_);
    if (!options_.progress(done, total_)) stopped_ = true;
  }
  bool stopped() const { return stopped_; }

 private:
  const InverseDynamicsOptions& options_;
  const int total_;
  std::atomic<int> done_ = 0;
  std::atomic<bool> stopped_ = false;
  std::mutex mutex_;
};

// The coordinates that have a column: none of a virtual link, where without mass and load nothing
// can act.
std::vector<std::size_t> reported_coordinates(const MusculoskeletalModel& model,
                                              const std::vector<CompiledCoupler>& couplers) {
  const std::size_t count = model.coordinates.size();
  std::vector<bool> dependent(count, false);
  for (const CompiledCoupler& c : couplers) dependent[c.dependent] = true;
  std::vector<std::size_t> reported;
  for (std::size_t c = 0; c < count; ++c) {
    const auto body = static_cast<std::size_t>(model.coordinates[c].joint) + 1;
    if (!dependent[c] && !model.bodies[body].virtual_link) reported.push_back(c);
  }
  return reported;
}

std::string force_label(const Coordinate& coordinate) {
  const bool turns = coordinate.motion == Coordinate::Motion::kRotational;
  return coordinate.name + (turns ? "_moment" : "_force");
}

Eigen::VectorXd frames_in_range(const CoordinateTable& motion,
                                const InverseDynamicsOptions& options) {
  const Eigen::Index rows = motion.time.size();
  const double first = motion.time[0], last = motion.time[rows - 1];
  const double slack = kRangeSlack * (last - first) / static_cast<double>(rows - 1);
  const double from = options.from.value_or(first) - slack;
  const double to = options.to.value_or(last) + slack;
  const auto begin = std::lower_bound(motion.time.begin(), motion.time.end(), from);
  const auto end = std::upper_bound(motion.time.begin(), motion.time.end(), to);
  if (begin >= end) {
    throw InputError({motion.path, 0},
                     {fmt::format("no frame from {:.6g} to {:.6g} s", from + slack, to - slack),
                      fmt::format("a range within {:.6g} to {:.6g} s", first, last), "",
                      "Choose a time range that the motion covers."});
  }
  return motion.time.segment(begin - motion.time.begin(), end - begin);
}

}  // namespace

void InverseDynamicsOptions::validate() const {
  const auto fail = [](const std::string& text) {
    throw std::invalid_argument("InverseDynamicsOptions::" + text);
  };
  if (!std::isfinite(cutoff) || cutoff == 0.0) {
    fail(fmt::format("cutoff is {} Hz; it must be positive, or negative for no filter", cutoff));
  }
  if ((from && !std::isfinite(*from)) || (to && !std::isfinite(*to))) {
    fail("from and to must be finite; leave them empty for the whole record");
  }
  if (from && to && *from > *to) fail(fmt::format("from is {} s, after to, {} s", *from, *to));
  if (threads < 0) {
    fail(fmt::format("threads is {}; it must be 0 (all) or positive", threads));
  }
}

CoordinateSpline motion_spline(const MusculoskeletalModel& model, const CoordinateTable& motion,
                               double cutoff) {
  constexpr Eigen::Index kFewest = 6;  // of a quintic spline
  if (motion.time.size() < kFewest) {
    throw InputError({motion.path, 0}, {"is too short to be differentiated", "6 frames or more",
                                        fmt::format("{}", motion.time.size()),
                                        "Take a longer record, or a longer part of it."});
  }
  try {
    if (cutoff < 0.0) return {motion.time, motion.q};
    TimeTable table;
    for (const Coordinate& c : model.coordinates) table.labels.push_back(c.name);
    table.time = motion.time;
    table.values = motion.q;
    const TimeTable filtered = lowpass_with_padding(table, cutoff);
    return {filtered.time, filtered.values};
  } catch (const std::invalid_argument& error) {
    throw InputError({motion.path, 0},
                     {std::string("cannot be differentiated: ") + error.what(), "", "", ""});
  }
}

TimeTable generalized_forces(const MusculoskeletalModel& model, const SimbodyModel& compiled,
                             const CoordinateSpline& motion, const ExternalLoads& loads,
                             const Eigen::VectorXd& times, const InverseDynamicsOptions& options) {
  options.validate();
  const std::size_t count = model.coordinates.size();
  if (motion.size() != compiled.coordinate_count() ||
      count != static_cast<std::size_t>(motion.size())) {
    throw std::invalid_argument(
        fmt::format("generalized_forces: the motion has {} coordinates, the model {} and its "
                    "compiled form {}",
                    motion.size(), count, compiled.coordinate_count()));
  }
  if (times.size() > 0) loads.require_coverage(times.minCoeff(), times.maxCoeff());

  const Solver solver(model, compiled, motion, loads, options);
  const std::vector<std::size_t> reported = reported_coordinates(model, solver.couplers());
  TimeTable result;
  result.name = "Inverse Dynamics Generalized Forces";
  result.in_degrees = false;
  result.time = times;
  result.values.setConstant(times.size(), static_cast<Eigen::Index>(reported.size()), kNaN);
  for (const std::size_t c : reported) result.labels.push_back(force_label(model.coordinates[c]));

  tbb::enumerable_thread_specific<Workspace> workspaces([&] { return Workspace(compiled); });
  Progress progress(options, static_cast<int>(times.size()));
  const auto solve_frames = [&](const tbb::blocked_range<Eigen::Index>& frames) {
    if (progress.stopped()) return;
    Workspace& w = workspaces.local();
    for (Eigen::Index i = frames.begin(); i < frames.end(); ++i) {
      solver.solve(times[i], w);
      for (std::size_t k = 0; k < reported.size(); ++k) {
        result.values(i, static_cast<Eigen::Index>(k)) = w.tau[reported[k]];
      }
      progress.frame_done();
    }
  };
  // oneTBB complains on stderr about more threads than the machine has.
  const int most = tbb::info::default_concurrency();
  tbb::task_arena arena(options.threads > 0 ? std::min(options.threads, most) : most);
  arena.execute([&] {
    tbb::parallel_for(tbb::blocked_range<Eigen::Index>(0, times.size(), kGrain), solve_frames);
  });
  return result;
}

InverseDynamicsResult inverse_dynamics(const MusculoskeletalModel& model,
                                       const SimbodyModel& compiled, const CoordinateTable& motion,
                                       const ExternalLoads& loads,
                                       const InverseDynamicsOptions& options) {
  options.validate();
  const CoordinateSpline spline = motion_spline(model, motion, options.cutoff);
  InverseDynamicsResult result;
  result.warnings = motion.warnings;
  result.warnings.insert(result.warnings.end(), loads.warnings().begin(), loads.warnings().end());
  const auto affected = CustomJointCorrection::affected_joints(model);
  if (!affected.empty() && !options.exact_custom_joints) {
    result.warnings.push_back(
        {{model.name, 0},
         fmt::format(
             "Simbody, and so OpenSim, gets accelerations wrong in custom joints whose turns "
             "share a coordinate or follow another order than the coordinates: {}. Exact custom "
             "joints (--exact-custom-joints) give torques that match the motion's energy",
             fmt::join(affected, ", "))});
  }
  InverseDynamicsOptions watched = options;
  if (options.progress) {
    watched.progress = [&](int done, int total) {
      if (!options.progress(done, total)) result.stopped = true;
      return !result.stopped;
    };
  }
  result.forces =
      generalized_forces(model, compiled, spline, loads, frames_in_range(motion, options), watched);
  return result;
}

}  // namespace sinew
