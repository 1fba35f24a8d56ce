#include "pipeline/push_evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "data/numbers.h"

namespace sinew {
namespace {

std::string axis_name(const LevelForce& level) {
  int axis = 0;
  level.axis.cwiseAbs().maxCoeff(&axis);
  return std::string(1, static_cast<char>('x' + axis));
}

// Frames in which a load is looked at, all of them or those of one contact.
struct Looked {
  std::vector<bool> frames;
  std::string times;
};

// The known frames, and those of each contact of the load that is known for long enough to tell.
std::vector<Looked> looks_at(const BodyForces& load, const Eigen::VectorXd& time,
                             const std::vector<bool>& known) {
  constexpr double kLongEnough = 0.3;  // [s] half of a stance
  std::vector<Looked> looks{{known, ""}};
  if (load.body < 0) return looks;
  const auto n = static_cast<Eigen::Index>(known.size());
  const auto acts = [&](Eigen::Index f) {
    return known[static_cast<std::size_t>(f)] && load.forces.row(f).norm() > kContactForce;
  };
  for (Eigen::Index first = 0, end = 0; first < n; first = end + 1) {
    end = first;
    while (end < n && acts(end)) ++end;
    if (end == first || time[end - 1] - time[first] < kLongEnough) continue;
    Looked contact{std::vector<bool>(known.size()),
                   fmt::format("from {:.2f} s to {:.2f} s", time[first], time[end - 1])};
    std::fill(contact.frames.begin() + first, contact.frames.begin() + end, true);
    looks.push_back(std::move(contact));
  }
  if (looks.size() == 2) looks.pop_back();  // the only one
  return looks;
}

// What the body's movement needs of the load is that load and what is left at the root.
PushEvidence push_along(const LevelForce& level, const RowMatrix& forces, const TimeTable& table,
                        const Looked& looked) {
  PushEvidence push;
  push.times = looked.times;
  push.axis = axis_name(level);
  const Eigen::VectorXd load = forces * level.axis, need = load + table.values.col(level.column);
  double dot = 0.0;
  for (Eigen::Index f = 0; f < load.size(); ++f) {
    if (looked.frames[static_cast<std::size_t>(f)]) dot += load[f] * need[f];
  }
  const auto n = static_cast<double>(std::count(looked.frames.begin(), looked.frames.end(), true));
  push.load_rms = rms_where(load, looked.frames);
  push.need_rms = rms_where(need, looked.frames);
  push.cosine = dot / (n * push.load_rms * push.need_rms);
  push.acts_rms = rms_where(forces.rowwise().norm(), looked.frames);
  return push;
}

TurnEvidence turn_of(const LevelForce& first, const LevelForce& second, const RowMatrix& forces,
                     const TimeTable& table, const Looked& looked) {
  TurnEvidence turn;
  turn.times = looked.times;
  const Eigen::VectorXd x = forces * first.axis, z = forces * second.axis,
                        left_x = table.values.col(first.column),
                        left_z = table.values.col(second.column);
  turn.load_rms = std::hypot(rms_where(x, looked.frames), rms_where(z, looked.frames));
  const double now = std::hypot(rms_where(left_x, looked.frames), rms_where(left_z, looked.frames));
  const std::string a = axis_name(first), b = axis_name(second);
  for (const double s : {1.0, -1.0}) {
    for (const double t : {1.0, -1.0}) {
      // The load would be (s z, t x): what is left gets the difference.
      const double then = std::hypot(rms_where(left_x + x - s * z, looked.frames),
                                     rms_where(left_z + z - t * x, looked.frames));
      if (then / now >= turn.left) continue;
      turn.left = then / now;
      turn.axes =
          fmt::format("{} is {}{}, {} is {}{}", a, s < 0.0 ? "-" : "", b, b, t < 0.0 ? "-" : "", a);
    }
  }
  return turn;
}

}  // namespace

double rms_where(const Eigen::VectorXd& values, const std::vector<bool>& wanted) {
  double sum = 0.0, all = 0.0;
  int count = 0;
  for (Eigen::Index f = 0; f < values.size(); ++f) {
    all += values[f] * values[f];
    if (!wanted[static_cast<std::size_t>(f)]) continue;
    sum += values[f] * values[f];
    ++count;
  }
  if (count > 0) return std::sqrt(sum / count);
  return std::sqrt(all / static_cast<double>(std::max<Eigen::Index>(values.size(), 1)));
}

void add_pushes(const MusculoskeletalModel& model, const std::vector<BodyForces>& loads,
                const std::vector<LevelForce>& level, const TimeTable& left,
                const std::vector<bool>& known, DynamicsEvidence& evidence) {
  for (const BodyForces& of : loads) {
    const std::string body =
        of.body < 0 ? std::string() : model.bodies[static_cast<std::size_t>(of.body)].name;
    for (const Looked& looked : looks_at(of, left.time, known)) {
      // One body's is the sum.
      if (of.body >= 0 && loads.size() == 2 && looked.times.empty()) continue;
      for (const LevelForce& along : level) {
        evidence.pushes.push_back(push_along(along, of.forces, left, looked));
        evidence.pushes.back().body = body;
      }
      if (level.size() != 2) continue;
      evidence.turns.push_back(turn_of(level[0], level[1], of.forces, left, looked));
      evidence.turns.back().body = body;
    }
  }
}

}  // namespace sinew
