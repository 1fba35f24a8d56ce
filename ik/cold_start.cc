#include "ik/cold_start.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>

#include "ik/root_alignment.h"

namespace sinew {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Costs that differ by less than this part are one minimum: what the gradient's tolerance leaves.
constexpr double kSameCost = 1e-6;

// Of costs that are the same, that of the earlier start is taken, unless a later one is lower by
// more than this part: which start is chosen does not hang on rounding.
constexpr double kPreferred = 1e-8;

// The same position to this [m] on every marker is a cost of zero: no laboratory measures a tenth
// of it. Wires and virtual links leave many minima below it, of which none is truer than another.
constexpr double kExact = 1e-5;

// The chosen solution is polished to this part of the gradient's tolerance: starts end anywhere
// within it, and where the model can meet the markers exactly that is up to 1e-7 m off on each, in
// a sixth of the random starts of tests/bench/survey.sh.
constexpr double kPolish = 1e-2;
constexpr int kPolishIterations = 500;

// Two starts that agree are enough where the cost has no better place beyond a bound. Wrong minima
// mostly sit on one: where going 0.1 rad beyond it would, by the gradient, save more than this part
// of the cost, so many starts are made at least. tests/bench/survey.md: with two, 6 of 17 starts of
// a running Rajagopal body ended in the same wrong minimum.
constexpr double kReach = 0.1, kHeldBack = 0.02;
constexpr int kMostDoubted = 8;

// So many starts are made, too, where markers are farther off than the second of these [m, RMS],
// what Hicks et al. 2015 (J Biomech Eng 137:020905) call the most that can be accepted, and half
// again. Between the two, where a fit of a scaled model rarely ends, fewer will do as long as none
// ends elsewhere; and two where a solved frame is looked at again, maybe many times in a trial.
constexpr double kBadFit = 0.010, kWorseFit = 0.025;
constexpr int kUnanimous = 4;

// How far unbounded joints turn from their default in random poses [rad], and the number that all
// seeds start from.
constexpr double kRandomTurn = 1.2;
constexpr std::uint64_t kSeed = 20120101;

// What a helper, whose end the options' own method polishes, is asked for. BFGS gathers its
// curvature over about as many iterations as there are unknowns.
constexpr double kHelperTolerance = 1e-6;
constexpr int kHelperIterations = 60, kBfgsIterations = 400;

// A dense inverse of more unknowns than these takes longer than L-BFGS needs.
constexpr int kMostForBfgs = 200;

enum Helper { kOwn, kQuasiNewton, kDamped, kHelperCount };

Method method_of(int helper, const KinematicTree& tree, Method own) {
  if (helper == kOwn) return own;
  if (helper == kDamped) {
    return own == Method::kLevenbergMarquardt ? Method::kGaussNewton : Method::kLevenbergMarquardt;
  }
  return tree.unknown_count() <= kMostForBfgs ? Method::kBfgs : Method::kLbfgs;
}

// Calls use(x, q entry) for every unknown that has a number of its own.
template <typename Use>
void for_each_entry(const KinematicTree& tree, const Use& use) {
  for (std::size_t x = 0; x < tree.unknown_v.size(); ++x) {
    const int q = tree.q_of_v[static_cast<std::size_t>(tree.unknown_v[x])];
    if (q >= 0) use(x, static_cast<std::size_t>(q));
  }
}

std::vector<int> depths_of(const KinematicTree& tree) {
  std::vector<int> depths(tree.links.size(), 0);
  for (std::size_t b = 1; b < depths.size(); ++b) {
    depths[b] = depths[static_cast<std::size_t>(tree.links[b].parent)] + 1;
  }
  return depths;
}

// Links that a measured marker is on, or on what hangs on them.
std::vector<char> carrying_links(const KinematicTree& tree, const IkProblem& problem,
                                 const IkTargets& targets) {
  std::vector<char> carries(tree.links.size(), 0);
  for (std::size_t i = 0; i < problem.positions.size(); ++i) {
    if (!targets.positions[i].hasNaN()) {
      carries[static_cast<std::size_t>(problem.positions[i].link)] = 1;
    }
  }
  for (std::size_t b = carries.size() - 1; b > 0; --b) {
    if (carries[b]) carries[static_cast<std::size_t>(tree.links[b].parent)] = 1;
  }
  return carries;
}

// A number in [0, 1) that is the same with every standard library.
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

// By whole turns as near to the range as they lead, then onto it.
double into_range(double value, double lower, double upper, bool turns) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  if (turns && value > upper) {
    const double back = value - kTurn * std::ceil((value - upper) / kTurn);
    if (back >= lower || lower - back < value - upper) value = back;
  } else if (turns && value < lower) {
    const double on = value + kTurn * std::ceil((lower - value) / kTurn);
    if (on <= upper || on - upper < lower - value) value = on;
  }
  return std::clamp(value, lower, upper);
}

double total_weight(const IkProblem& problem) {
  double sum = 0.0;
  for (const PositionResidual& r : problem.positions) sum += r.weight.trace() / 3.0;
  return sum;
}

double measured_weight(const IkProblem& problem, const IkTargets& targets) {
  double weight = 0.0;
  for (std::size_t i = 0; i < problem.positions.size(); ++i) {
    if (targets.positions[i].hasNaN()) continue;
    weight += position_weight(problem, targets, i).trace() / 3.0;
  }
  return weight;
}

}  // namespace

struct ColdStart::Start {
  enum class Pose { kGiven, kAligned, kDefault, kMiddle, kRandom };
  Pose pose = Pose::kGiven;
  bool outward = false;     // limbs one after the other, from there
  bool free_first = false;  // bounds are left away first
  int helper = kOwn;
  std::uint64_t seed = 0;

  // Starts that agree tell more than one does if neither pose nor method is the same.
  bool independent_of(const Start& other) const {
    const bool same_pose = pose == other.pose && outward == other.outward && seed == other.seed;
    return !same_pose && (helper != other.helper || seed != other.seed);
  }

  static Start cold(int i) {
    const auto random = static_cast<std::uint64_t>(i);
    switch (i) {
      case 0:
        return {Pose::kAligned, false, false, kOwn, 0};
      case 1:
        return {Pose::kDefault, true, true, kDamped, 0};
      case 2:
        return {Pose::kDefault, false, false, kQuasiNewton, 0};
      case 3:
        return {Pose::kMiddle, false, true, kOwn, 0};
      case 4:
        return {Pose::kMiddle, true, false, kQuasiNewton, 0};
      default:
        return {Pose::kRandom, i % 2 == 0, i % 4 < 2, i % kHelperCount, random};
    }
  }

  static Start again(int i) {
    switch (i) {
      case 0:
        return {Pose::kGiven, false, true, kOwn, 0};
      case 1:
        return {Pose::kDefault, true, true, kDamped, 0};
      case 2:
        return {Pose::kGiven, false, false, kQuasiNewton, 0};
      default:
        return cold(i);
    }
  }
};

struct ColdStart::Found {
  Start start;
  std::vector<double> q;
  Summary summary;
  bool plausible = true;
};

bool joints_are_plausible(const KinematicTree& tree, std::span<const double> q) {
  const auto turned_too_far = [&](int entry) {
    const auto i = static_cast<std::size_t>(entry);
    return std::abs(q[i] - tree.default_q[i]) > std::numbers::pi;
  };
  for (const KinematicTree::Link& link : tree.links) {
    for (int i = 0; i < link.rotation_count + link.translation_count; ++i) {
      const KinematicTree::Step& step = tree.steps[static_cast<std::size_t>(link.first_step + i)];
      if (step.q >= 0 && step.function >= 0 && turned_too_far(step.q)) return false;
    }
  }
  return std::none_of(
      tree.couplings.begin(), tree.couplings.end(),
      [&](const KinematicTree::Coupling& c) { return turned_too_far(c.independent_q); });
}

void ColdStartOptions::validate() const {
  if (starts < 1) {
    throw std::invalid_argument(
        fmt::format("ColdStartOptions.starts is {}; expected 1 or more", starts));
  }
}

ColdStart::ColdStart(const KinematicTree& tree, const IkProblem& problem,
                     const MinimizerOptions& minimizer, const ColdStartOptions& options)
    : tree_(tree),
      problem_(problem),
      options_(minimizer),
      search_(options),
      relaxed_(tree),
      exact_(0.5 * total_weight(problem) * kExact * kExact),
      final_(tree, problem, minimizer),
      helpers_(kHelperCount),
      turns_(tree.unknown_v.size(), 0) {
  options.validate();
  for (std::size_t x = 0; x < tree.lower.size(); ++x) {
    bounded_ = bounded_ || std::isfinite(tree.lower[x]) || std::isfinite(tree.upper[x]);
  }
}

ColdStart::~ColdStart() = default;

Minimizer& ColdStart::helper(int kind) {
  auto& minimizer = helpers_[static_cast<std::size_t>(kind)];
  if (!minimizer) {
    MinimizerOptions options = options_;
    options.method = method_of(kind, tree_, options_.method);
    options.gradient_tolerance = std::max(options_.gradient_tolerance, kHelperTolerance);
    options.max_iterations = std::min(options_.max_iterations,
                                      kind == kQuasiNewton ? kBfgsIterations : kHelperIterations);
    options.record_iterations = false;
    minimizer = std::make_unique<Minimizer>(relaxed_, problem_, options);
  }
  return *minimizer;
}

// The pose that a start begins from. What no unknown sets stays as given.
std::vector<double> ColdStart::pose(const Start& start, const IkTargets& targets,
                                    std::span<const double> given) {
  std::vector<double> q(given.begin(), given.end());
  if (start.pose == Start::Pose::kGiven) return q;
  const std::vector<char> carries = carrying_links(tree_, problem_, targets);
  std::mt19937_64 random(kSeed + start.seed);
  if (start.pose != Start::Pose::kAligned) {
    for_each_entry(tree_, [&](std::size_t x, std::size_t entry) {
      const auto v = static_cast<std::size_t>(tree_.unknown_v[x]);
      const double lower = tree_.lower[x], upper = tree_.upper[x], middle = tree_.default_q[entry];
      q[entry] = middle;
      const bool determined = carries[static_cast<std::size_t>(tree_.link_of_v[v])];
      const bool ranged = std::isfinite(lower) && std::isfinite(upper);
      if (start.pose == Start::Pose::kMiddle && ranged) q[entry] = 0.5 * (lower + upper);
      if (start.pose != Start::Pose::kRandom) return;
      const double u = uniform(random);
      if (!determined) return;
      if (ranged) {
        const double most = turns_[x] ? std::numbers::pi : kInfinity;
        const double from = std::max(lower, middle - most), to = std::min(upper, middle + most);
        q[entry] = from < to ? from + u * (to - from) : std::clamp(middle, lower, upper);
      } else if (turns_[x]) {
        q[entry] = std::clamp(middle + kRandomTurn * (2.0 * u - 1.0), lower, upper);
      }
    });
  }
  if (start.outward) return outward(targets, std::move(q));
  align_roots(tree_, problem_, targets, {}, q);
  return q;
}

// Joints by their depth in the tree, each time with the markers that they move so far.
std::vector<double> ColdStart::outward(const IkTargets& targets, std::vector<double> q) {
  const std::vector<int> depths = depths_of(tree_);
  std::vector<int> stages;
  for (std::size_t i = 0; i < problem_.positions.size(); ++i) {
    if (targets.positions[i].hasNaN()) continue;
    stages.push_back(depths[static_cast<std::size_t>(problem_.positions[i].link)]);
  }
  std::sort(stages.begin(), stages.end());
  stages.erase(std::unique(stages.begin(), stages.end()), stages.end());
  align_roots(tree_, problem_, targets, {}, q);
  if (stages.empty()) return q;
  std::vector<char> links(depths.size(), 0);
  for (std::size_t b = 0; b < links.size(); ++b) links[b] = depths[b] <= stages.front();
  align_roots(tree_, problem_, targets, links, q);
  for (const int stage : stages) {
    IkTargets so_far = targets;
    for (std::size_t i = 0; i < problem_.positions.size(); ++i) {
      if (depths[static_cast<std::size_t>(problem_.positions[i].link)] > stage) {
        so_far.positions[i].setConstant(kNaN);
      }
    }
    for_each_entry(tree_, [&](std::size_t x, std::size_t entry) {
      const auto v = static_cast<std::size_t>(tree_.unknown_v[x]);
      const bool free = depths[static_cast<std::size_t>(tree_.link_of_v[v])] <= stage;
      relaxed_.lower[x] = free ? tree_.lower[x] : q[entry];
      relaxed_.upper[x] = free ? tree_.upper[x] : q[entry];
    });
    helper(kOwn).minimize(so_far, q);
  }
  return q;
}

// From q to a minimum within the bounds.
void ColdStart::descend(const Start& start, const IkTargets& targets, std::vector<double>& q) {
  int evaluations = 0;
  if (start.free_first && bounded_) {
    std::fill(relaxed_.lower.begin(), relaxed_.lower.end(), -kInfinity);
    std::fill(relaxed_.upper.begin(), relaxed_.upper.end(), kInfinity);
    evaluations += helper(start.helper).minimize(targets, q).evaluations;
    for_each_entry(tree_, [&](std::size_t x, std::size_t entry) {
      q[entry] = into_range(q[entry], tree_.lower[x], tree_.upper[x], turns_[x]);
    });
  }
  if (start.helper != kOwn) {
    relaxed_.lower = tree_.lower;
    relaxed_.upper = tree_.upper;
    evaluations += helper(start.helper).minimize(targets, q).evaluations;
  }
  const Summary& summary = final_.minimize(targets, q);
  found_.push_back({start, q, summary, joints_are_plausible(tree_, q)});
  found_.back().summary.evaluations += evaluations;
}

// Whether the lowest cost has been met by two starts that are independent; counts those that did.
bool ColdStart::agreed() {
  const double most = lowest_ * (1.0 + kSameCost) + exact_;
  const auto is_lowest = [&](const Found& f) {
    return f.plausible && f.summary.final_cost <= most;
  };
  result_.agreeing = 0;
  bool agreed = false;
  for (const Found& a : found_) {
    if (!is_lowest(a)) continue;
    ++result_.agreeing;
    for (const Found& b : found_) {
      agreed = agreed || (is_lowest(b) && a.start.independent_of(b.start));
    }
  }
  return agreed;
}

// How many starts to make at least, by what the best solution so far is like. `weight`: of the
// measured markers; `again`: from a solution that is doubted.
int ColdStart::least_starts(double weight, bool again) const {
  const Found& found = best();
  const double cost = found.summary.final_cost;
  if (!again && kReach * found.summary.bound_push > kHeldBack * cost) return kMostDoubted;
  const auto is_farther = [&](double limit) { return cost > 0.5 * weight * limit * limit; };
  if (is_farther(kWorseFit)) return kMostDoubted;
  if (again || !is_farther(kBadFit)) return 2;
  const bool unanimous = result_.agreeing == static_cast<int>(found_.size());
  return unanimous ? kUnanimous : kMostDoubted;
}

void ColdStart::search(const IkTargets& targets, std::span<const double> given, bool again) {
  result_ = {};
  {  // turns and shifts are told apart by their columns
    KinematicWorkspace& ws = final_.workspace();
    std::copy(given.begin(), given.end(), ws.q.begin());
    update_kinematics(tree_, ws);
    for (std::size_t x = 0; x < turns_.size(); ++x) {
      const auto v = static_cast<std::size_t>(tree_.unknown_v[x]);
      turns_[x] = ws.S[v].head<3>().norm() > 0.0;
    }
  }
  const double weight = measured_weight(problem_, targets);
  for (int i = 0; i < search_.starts; ++i) {
    const Start start = again ? Start::again(i) : Start::cold(i);
    std::vector<double> q = pose(start, targets, given);
    descend(start, targets, q);
    const double cost = found_.back().summary.final_cost;
    if (found_.back().plausible && cost < lowest_) lowest_ = cost;
    result_.starts = i + 1;
    result_.agreed = agreed();
    if (lowest_ <= exact_ && best().summary.converged()) break;
    if (result_.agreed && result_.starts >= least_starts(weight, again)) break;
  }
  result_.lowest = lowest_;
  for (const Found& found : found_) {
    const double cost = found.summary.final_cost;
    if (found.plausible && cost > lowest_ * (1.0 + kSameCost) + exact_ &&
        !(cost >= result_.second_lowest)) {
      result_.second_lowest = cost;
    }
  }
}

// Of the starts that ended lowest, the first.
const ColdStart::Found& ColdStart::best() const {
  const double most = lowest_ * (1.0 + kPreferred) + exact_;
  const auto found = std::find_if(found_.begin(), found_.end(), [&](const Found& f) {
    return f.plausible && f.summary.final_cost <= most;
  });
  return found == found_.end() ? found_.front() : *found;
}

// The workspace is that of the last descent; it becomes that of the best.
void ColdStart::settle(const IkTargets& targets, std::span<double> q) {
  Found chosen = best();
  int evaluations = 0;
  for (const Found& found : found_) evaluations += found.summary.evaluations;
  if (search_.starts > 1 && options_.gradient_tolerance > 0.0) {
    MinimizerOptions polish = options_;
    polish.gradient_tolerance *= kPolish;
    polish.max_iterations = std::min(options_.max_iterations, kPolishIterations);
    polish.record_iterations = false;
    std::vector<double> polished = chosen.q;
    const Summary summary = Minimizer(tree_, problem_, polish).minimize(targets, polished);
    evaluations += summary.evaluations;
    if (summary.final_cost <= chosen.summary.final_cost && joints_are_plausible(tree_, polished)) {
      chosen.q = polished;
      chosen.summary.final_cost = summary.final_cost;
    }
  }
  summary_ = chosen.summary;
  summary_.evaluations = evaluations;
  std::copy(chosen.q.begin(), chosen.q.end(), q.begin());
  KinematicWorkspace& ws = final_.workspace();
  std::copy(chosen.q.begin(), chosen.q.end(), ws.q.begin());
  update_kinematics(tree_, ws);
}

const Summary& ColdStart::minimize(const IkTargets& targets, std::span<double> q) {
  found_.clear();
  lowest_ = kInfinity;
  if (search_.starts == 1) {  // the given pose, as it is
    found_.push_back({{}, std::vector<double>(q.begin(), q.end()), {}, true});
    found_.back().summary = final_.minimize(targets, found_.back().q);
    lowest_ = found_.back().summary.final_cost;
    result_ = {1, 1, false, lowest_, kNaN};
  } else {
    search(targets, std::vector<double>(q.begin(), q.end()), false);
  }
  settle(targets, q);
  return summary_;
}

bool ColdStart::look_again(const IkTargets& targets, std::span<double> q, double cost) {
  const std::vector<double> doubted(q.begin(), q.end());
  found_.clear();
  found_.push_back({{}, doubted, {}, true});
  found_.back().summary.final_cost = lowest_ = cost;
  found_.back().summary.evaluations = 0;
  search(targets, doubted, true);
  if (!(lowest_ < cost * (1.0 - kSameCost) - exact_)) return false;
  settle(targets, q);
  return true;
}

}  // namespace sinew
