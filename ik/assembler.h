#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ik/minimizer.h"
#include "ik/tracking.h"
#include "model/simbody_model.h"

namespace sinew {

/// Simbody's own Assembler on the same residuals: the second opinion on our solutions. Markers,
/// coordinate targets and wires with the same weights are its goals, locked coordinates are locked,
/// clamped ones restricted; couplers and loops are constraints of the system, which it satisfies to
/// a tolerance of accuracy/10 where we eliminate couplers. All else is left at its defaults.
class AssemblerSolver {
 public:
  /// accuracy: Assembler::setAccuracy; 0 leaves Simbody's default, 1e-3. Keeps a reference to
  /// `tracking`.
  AssemblerSolver(const MusculoskeletalModel& model, const TrackingProblem& tracking,
                  double accuracy);
  ~AssemblerSolver();

  struct Frame {
    bool succeeded = false;
    std::string failure;             // Simbody's message
    double constraint_error = kNaN;  // its largest error of a constraint [rad or m]
    double seconds = kNaN;           // inside assemble() or track()
  };

  /// Solves one frame from the last frame's solution, the first from q. q: coordinates of the
  /// model; on return the solution. `targets` in the order of `tracking`.
  Frame solve(const IkTargets& targets, double time, std::span<double> q);

 private:
  struct Simbody;
  std::unique_ptr<Simbody> simbody_;
};

struct AssemblerComparisonOptions {
  MinimizerOptions minimizer;
  ColdStartOptions cold_start;
  double accuracy = 1e-7;  // of the Assembler
  int first_frame = 0, end_frame = -1, every = 1;
  /// The verdict: our cost may exceed the Assembler's by this fraction of it.
  double tolerance = 1e-6;
  std::function<bool(int done, int total)> progress;

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

struct ComparedFrame {
  int frame = -1;
  double time = kNaN;                                     // [s]
  double cost = kNaN, assembler_cost = kNaN;              // by the same code
  double marker_rms = kNaN, assembler_marker_rms = kNaN;  // [m]
  double assembler_constraint_error = kNaN;
  double seconds = kNaN, assembler_seconds = kNaN;
  Termination termination = Termination::kNone;
  bool assembler_succeeded = false;
  bool worse = false;  // than the tolerance allows
};

struct Comparison {
  std::vector<ComparedFrame> frames;
  Eigen::VectorXd angle_rms, angle_max;  // per coordinate: ours − Assembler's [rad or m]
  std::vector<int> undetermined;         // coordinates that no marker or task determines
  int worse_frames = 0, assembler_failures = 0;
  double worst_cost_excess = kNaN;  // largest (ours − theirs)/theirs
  double seconds = 0.0, assembler_seconds = 0.0;
  double assembler_default_seconds = kNaN;  // of the same frames at Simbody's default accuracy
  bool stopped = false;
};

/// Solves the chosen frames by both, one thread each: ours are those of track() over the whole
/// range, whose `seconds` are those of the descent of each frame alone; the Assembler goes from its
/// own last solution.
/// Costs below those of 1e-5 mm on every marker count as equal, so that
/// frames which both meet to rounding are not judged by their noise.
Comparison compare_with_assembler(const MusculoskeletalModel& model, const KinematicTree& tree,
                                  const TrackingProblem& tracking,
                                  const MarkerTrajectories& markers,
                                  const AssemblerComparisonOptions& options);

}  // namespace sinew
