#pragma once

#include <memory>
#include <span>
#include <vector>

#include "ik/minimizer.h"
#include "ik/residuals.h"
#include "model/kinematic_tree.h"

namespace sinew {

/// False where a joint that functions follow, as the shifts of a knee follow its angle, has turned
/// by more than half a turn from its default: knees do not turn so far, and the functions are lines
/// there. Other joints may be anywhere: whole turns away they are where they should be.
bool joints_are_plausible(const KinematicTree& tree, std::span<const double> q);

struct ColdStartOptions {
  // Most starts of a search; 1: the given one alone. tests/bench/survey.md has what more gain.
  int starts = 24;

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// What a search found.
struct ColdStartResult {
  int starts = 0;       // that were made
  int agreeing = 0;     // of these, how many ended at the lowest cost
  bool agreed = false;  // two that are independent did
  double lowest = kNaN;
  double second_lowest = kNaN;  // cost of the next higher minimum; NaN where none was found
};

/// The lowest of several descents, for frames that no solved frame leads to. No single descent from
/// one pose is safe: with bounds each method ends in wrong minima on some recordings.
///
/// Starts, in order: the given pose with the root aligned to its markers (align_roots()), the
/// default pose, the middle of all ranges, limbs one after the other outward from the root, each
/// with the markers so far, and seeded random poses. In turn the bounds are left away first and
/// imposed afterwards, and the method is the options' own or another one that fails elsewhere
/// (BFGS, or L-BFGS for many unknowns; Levenberg-Marquardt). All end by the options' method at its
/// own tolerance. The search stops when two starts that differ in pose and method agree on the
/// lowest cost to 1e-6 of it (not before eight where a bound holds back much of it or markers are
/// more than 10 mm off), when it is zero to rounding, or at the number of starts. Minima that are
/// not plausible, see joints_are_plausible(), do not count.
///
/// Nothing of it depends on time or threads. Keeps references to tree and problem. Allocates.
class ColdStart {
 public:
  ColdStart(const KinematicTree& tree, const IkProblem& problem, const MinimizerOptions& minimizer,
            const ColdStartOptions& options);
  ~ColdStart();

  /// From q, and from elsewhere, to the lowest minimum, written to q. The Summary is of the descent
  /// that ended there, with the evaluations of all; it stays valid until the next call.
  const Summary& minimize(const IkTargets& targets, std::span<double> q);

  /// The same from a solution that is doubted: q is not aligned, and a minimum is taken in its
  /// place only if it is lower by more than 1e-6 of its cost. True if one was.
  bool look_again(const IkTargets& targets, std::span<double> q, double cost);

  const ColdStartResult& result() const { return result_; }
  /// Of the descent that ended lowest.
  const Summary& summary() const { return summary_; }
  /// Kinematics of the solution.
  KinematicWorkspace& workspace() { return final_.workspace(); }

 private:
  struct Start;
  struct Found;

  std::vector<double> pose(const Start& start, const IkTargets& targets,
                           std::span<const double> given);
  std::vector<double> outward(const IkTargets& targets, std::vector<double> q);
  void descend(const Start& start, const IkTargets& targets, std::vector<double>& q);
  bool agreed();
  int least_starts(double weight, bool again) const;
  void search(const IkTargets& targets, std::span<const double> given, bool again);
  const Found& best() const;
  void settle(const IkTargets& targets, std::span<double> q);
  Minimizer& helper(int kind);

  const KinematicTree& tree_;
  const IkProblem& problem_;
  MinimizerOptions options_;
  ColdStartOptions search_;
  KinematicTree relaxed_;  // bounds are left away or narrowed from descent to descent
  bool bounded_ = false;
  double exact_ = 0.0;  // a cost that is zero to rounding
  Minimizer final_;
  std::vector<std::unique_ptr<Minimizer>> helpers_;  // on relaxed_, made when first asked for
  std::vector<char> turns_;                          // unknowns: 1 turns, 0 shifts
  std::vector<Found> found_;
  double lowest_ = kNaN;
  ColdStartResult result_;
  Summary summary_;
};

}  // namespace sinew
