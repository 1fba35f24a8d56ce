#include "data/force_signal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "data/numbers.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// Rows per second, or 0 if steps differ by more than 1 %.
double even_rate(const Eigen::VectorXd& time) {
  const Eigen::Index last = time.size() - 1;
  if (last < 2 || !(time[last] > time[0])) return 0.0;
  const double step = (time[last] - time[0]) / static_cast<double>(last);
  for (Eigen::Index i = 1; i <= last; ++i) {
    // Times are written to some digits, and so their steps may jump while they keep to a line.
    const double expected = time[0] + static_cast<double>(i) * step;
    if (std::abs(time[i] - expected) > 0.5 * step) return 0.0;
  }
  return 1.0 / step;
}

int column(const TimeTable& table, const std::string& base, const char* end) {
  return table.find_column(base + end);
}

// Follows one signal from contact to contact.
class Walker {
 public:
  Walker(const ForceSignal& signal, int index, const Vector3d& up,
         const ForceContactOptions& options)
      : signal_(signal), index_(index), up_(up), options_(options) {}

  std::vector<ForceContact> walk() {
    bool loaded = false;
    for (Eigen::Index i = 0; i < signal_.force.rows(); ++i) {
      const double force = normal(i);
      if (!loaded && force >= options_.threshold) {
        begin(i);
        loaded = true;
      } else if (loaded && !(force >= options_.release)) {
        end(i);
        loaded = false;
      }
      if (loaded) add(i, force);
    }
    if (loaded) {
      contact_.ends = false;
      contact_.to = signal_.time(signal_.force.rows() - 1);
      keep();
    }
    return std::move(found_);
  }

 private:
  double normal(Eigen::Index i) const { return signal_.force.row(i).dot(up_.transpose()); }

  // Where the line from the sample before crosses `level`.
  double crossing(Eigen::Index i, double level) const {
    if (i == 0) return signal_.time(0);
    const double before = normal(i - 1), now = normal(i);
    const double s = std::abs(now - before) > 0.0 ? (level - before) / (now - before) : 1.0;
    return signal_.time(i - 1) + std::clamp(std::isfinite(s) ? s : 1.0, 0.0, 1.0) / signal_.rate;
  }

  void begin(Eigen::Index i) {
    contact_ = {};
    contact_.signal = index_;
    contact_.begins = i > 0;
    contact_.from = crossing(i, options_.threshold);
    center_.setZero();
    weight_ = 0.0;
  }
  void add(Eigen::Index i, double force) {
    contact_.peak = std::max(contact_.peak, force);
    const Vector3d p = signal_.center.row(i).transpose();
    if (!p.allFinite()) return;
    center_ += force * p;
    weight_ += force;
  }
  void end(Eigen::Index i) {
    contact_.to = crossing(i, options_.release);
    keep();
  }
  void keep() {
    contact_.center = weight_ > 0.0 ? Vector3d(center_ / weight_) : Vector3d::Constant(kNaN);
    const bool long_enough = contact_.to - contact_.from >= options_.shortest;
    if (long_enough && contact_.peak >= options_.least_peak) found_.push_back(contact_);
  }

  const ForceSignal& signal_;
  const int index_;
  const Vector3d up_;
  const ForceContactOptions& options_;
  ForceContact contact_;
  Vector3d center_ = Vector3d::Zero();
  double weight_ = 0.0;
  std::vector<ForceContact> found_;
};

}  // namespace

void ForceContactOptions::validate() const {
  if (!(release > 0.0 && release <= threshold)) {
    throw std::invalid_argument(
        fmt::format("ForceContactOptions::release is {}; it must be above 0 N and at most the "
                    "threshold, {} N",
                    release, threshold));
  }
  if (!(shortest >= 0.0 && least_peak >= 0.0)) {
    throw std::invalid_argument(
        fmt::format("ForceContactOptions::shortest is {} s and least_peak {} N; both must be at "
                    "least 0",
                    shortest, least_peak));
  }
}

std::vector<ForceSignal> force_signals(const std::vector<ForcePlatformRecording>& plates) {
  std::vector<ForceSignal> signals;
  for (const ForcePlatformRecording& plate : plates) {
    if (!plate.platform.usable() || plate.sample_count() == 0) continue;
    ForceSignal signal;
    signal.name = fmt::format("platform {}", plate.platform.number);
    signal.plate = plate.platform.number;
    signal.rate = plate.rate;
    signal.force = plate.force;
    signal.center = plate.center;
    signals.push_back(std::move(signal));
  }
  return signals;
}

std::vector<ForceSignal> force_signals(const TimeTable& table, double threshold) {
  std::vector<ForceSignal> signals;
  const double rate = even_rate(table.time);
  if (rate == 0.0) return signals;
  for (const std::string& label : table.labels) {
    if (!label.ends_with("vx")) continue;
    const std::string base = label.substr(0, label.size() - 2);
    const int force[3] = {column(table, base, "vx"), column(table, base, "vy"),
                          column(table, base, "vz")};
    const int center[3] = {column(table, base, "px"), column(table, base, "py"),
                           column(table, base, "pz")};
    if (std::min({force[1], force[2], center[0], center[1], center[2]}) < 0) continue;
    ForceSignal signal;
    signal.name = base.ends_with('_') ? base.substr(0, base.size() - 1) : base;
    signal.rate = rate;
    signal.start = table.time[0];
    signal.force.resize(table.time.size(), 3);
    signal.center.resize(table.time.size(), 3);
    for (int k = 0; k < 3; ++k) {
      signal.force.col(k) = table.values.col(force[k]);
      signal.center.col(k) = table.values.col(center[k]);
    }
    for (Eigen::Index i = 0; i < signal.force.rows(); ++i) {
      if (!(signal.force.row(i).norm() >= threshold)) signal.center.row(i).setConstant(kNaN);
    }
    signals.push_back(std::move(signal));
  }
  return signals;
}

std::vector<ForceContact> find_contacts(const std::vector<ForceSignal>& signals, const Vector3d& up,
                                        const ForceContactOptions& options) {
  options.validate();
  std::vector<ForceContact> contacts;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    const std::vector<ForceContact> found =
        Walker(signals[i], static_cast<int>(i), up, options).walk();
    contacts.insert(contacts.end(), found.begin(), found.end());
  }
  return contacts;
}

}  // namespace sinew
