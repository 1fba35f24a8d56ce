#include "dynamics/external_loads.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "data/butterworth.h"
#include "data/natural_spline.h"

namespace sinew {
namespace {

// From this many samples on, a cubic spline has its conditions; OpenSim changes over there too.
constexpr Eigen::Index kSplineSamples = 4;

int require_body(const MusculoskeletalModel& model, const ExternalLoadsSetup& setup,
                 const ExternalForce& force, const std::string& name, const char* element) {
  const int body = model.find_body(name);
  if (body < 0) {
    throw InputError({setup.path, force.line},
                     {fmt::format("<{}> of external force '{}' names no body of model '{}'",
                                  element, force.name, model.name),
                      "a body's name or ground", name, "Correct the name."});
  }
  return body;
}

// Indices of a part's three columns; nothing where the load has no such part.
std::vector<int> require_columns(const ExternalLoadsSetup& setup, const ExternalForce& force,
                                 const std::vector<std::string>& labels, const char* part,
                                 const TimeTableFile& data) {
  if (labels.empty()) return {};
  if (labels.size() != 3) {
    throw InputError({setup.path, force.line},
                     {fmt::format("external force '{}' has {} columns for its {}", force.name,
                                  labels.size(), part),
                      "3", "", "Name the columns of x, y and z."});
  }
  std::vector<int> columns;
  for (const std::string& label : labels) {
    columns.push_back(data.table.find_column(label));
    if (columns.back() >= 0) continue;
    throw InputError(
        {setup.path, force.line},
        {fmt::format("{} has no column '{}', which external force '{}' needs for its {}", data.path,
                     label, force.name, part),
         "", fmt::format("{}", fmt::join(data.table.labels, " ")),
         "Correct the identifier or the labels."});
  }
  return columns;
}

// The data without rows that say again what the row before said.
TimeTableFile without_repeated_rows(const TimeTableFile& data, std::vector<Warning>& warnings) {
  const TimeTable& table = data.table;
  if (table.time.size() == 0) {
    throw InputError({data.path, 0}, {"holds no rows of external loads", "", "",
                                      "Record loads or leave the file out."});
  }
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < table.time.size(); ++i) {
    if (kept.empty() || table.time[i] > table.time[kept.back()]) {
      kept.push_back(i);
      continue;
    }
    const bool identical =
        table.time[i] == table.time[kept.back()] &&
        (table.values.row(i).array() == table.values.row(kept.back()).array() ||
         (table.values.row(i).array().isNaN() && table.values.row(kept.back()).array().isNaN()))
            .all();
    if (!identical) {
      throw InputError(
          {data.path, 0},
          {fmt::format("two rows of external loads differ at one time, row {} and the "
                       "one before it",
                       i + 1),
           "increasing time", fmt::format("{} s", table.time[i]), "Remove one of the rows."});
    }
  }
  if (static_cast<Eigen::Index>(kept.size()) == table.time.size()) return data;
  TimeTableFile result = data;
  result.table.time = table.time(kept).eval();
  result.table.values = table.values(kept, Eigen::all).eval();
  warnings.push_back({{data.path, 0},
                      fmt::format("dropped {} repeated rows of external loads",
                                  table.time.size() - result.table.time.size())});
  return result;
}

// Straight lines between the measured values of a column, level beyond them.
void fill_gaps(const Eigen::VectorXd& time,
               Eigen::Ref<Eigen::VectorXd, 0, Eigen::InnerStride<>> v) {
  Eigen::Index before = -1;
  for (Eigen::Index i = 0; i <= v.size(); ++i) {
    if (i < v.size() && std::isnan(v[i])) continue;
    for (Eigen::Index k = before + 1; k < i; ++k) {
      if (before < 0 && i == v.size()) {
        v[k] = 0.0;
      } else if (before < 0 || i == v.size()) {
        v[k] = v[before < 0 ? i : before];
      } else {
        const double part = (time[k] - time[before]) / (time[i] - time[before]);
        v[k] = v[before] + part * (v[i] - v[before]);
      }
    }
    before = i;
  }
}

void require_finite(const TimeTableFile& data, const std::vector<int>& columns) {
  for (const int column : columns) {
    for (Eigen::Index i = 0; i < data.table.time.size(); ++i) {
      const double value = data.table.values(i, column);
      if (std::isfinite(value)) continue;
      throw InputError({data.path, 0},
                       {fmt::format("column '{}' of the external loads in row {}, at {} s",
                                    data.table.labels[static_cast<std::size_t>(column)], i + 1,
                                    data.table.time[i]),
                        "a number", fmt::format("{}", value),
                        "Fill the gap, or write zeros if nothing touched the plate."});
    }
  }
}

}  // namespace

void ExternalLoadsOptions::validate() const {
  if (std::isfinite(cutoff) && cutoff != 0.0) return;
  throw std::invalid_argument(fmt::format(
      "ExternalLoadsOptions::cutoff is {} Hz; it must be positive, or negative for no filter",
      cutoff));
}

ExternalLoads::ExternalLoads(const MusculoskeletalModel& model, const ExternalLoadsSetup& setup,
                             const TimeTableFile& data, const ExternalLoadsOptions& options)
    : data_source_{data.path, 0} {
  options.validate();
  const TimeTableFile rows = without_repeated_rows(data, warnings_);
  const Eigen::VectorXd& time = rows.table.time;
  first_time_ = time[0];
  last_time_ = time[time.size() - 1];
  if (time.size() > 1) {
    mean_step_ = (last_time_ - first_time_) / static_cast<double>(time.size() - 1);
  }
  TimeTable samples;
  samples.time = time;
  for (const ExternalForce& force : setup.forces) {
    if (force.applies) bind(model, setup, force, rows, samples);
  }
  if (loads_.empty()) return;
  if (options.cutoff > 0.0) filter(setup, options.cutoff, samples);
  fit(samples);
}

// Appends the load's nine components to `samples`, zero where it has none.
void ExternalLoads::bind(const MusculoskeletalModel& model, const ExternalLoadsSetup& setup,
                         const ExternalForce& force, const TimeTableFile& data,
                         TimeTable& samples) {
  Load load;
  load.frames.body = require_body(model, setup, force, force.applied_to_body, "applied_to_body");
  load.frames.force_frame =
      require_body(model, setup, force, force.force_expressed_in_body, "force_expressed_in_body");
  load.frames.point_frame = load.frames.body;  // without a point, the force acts at the origin
  const auto forces = require_columns(setup, force, force.force_columns, "force", data);
  const auto points = require_columns(setup, force, force.point_columns, "point", data);
  const auto torques = require_columns(setup, force, force.torque_columns, "torque", data);
  load.has_point = !points.empty();
  load.line = force.line;
  if (load.has_point) {
    load.frames.point_frame =
        require_body(model, setup, force, force.point_expressed_in_body, "point_expressed_in_body");
  }
  require_finite(data, forces);
  require_finite(data, torques);

  const Eigen::Index rows = samples.time.size(), first = samples.values.cols();
  RowMatrix values = RowMatrix::Zero(rows, first + kComponents);
  if (first > 0) values.leftCols(first) = samples.values;
  const auto copy = [&](const std::vector<int>& from, Eigen::Index to) {
    for (std::size_t k = 0; k < from.size(); ++k) {
      values.col(first + to + static_cast<Eigen::Index>(k)) = data.table.values.col(from[k]);
    }
  };
  copy(forces, 0);
  copy(points, 3);
  copy(torques, 6);
  Eigen::Index filled = 0;
  for (Eigen::Index i = 0; load.has_point && i < rows; ++i) {
    if (!values.row(i).segment(first + 3, 3).hasNaN()) continue;
    if (!values.row(i).segment(first, 3).isZero(0.0)) require_finite(data, points);
    ++filled;
  }
  if (filled > 0) {
    for (Eigen::Index k = 3; k < 6; ++k) fill_gaps(samples.time, values.col(first + k));
    warnings_.push_back(
        {{setup.path, force.line},
         fmt::format("external force '{}' has no point in {} rows where it is zero; filled from "
                     "the rows around them",
                     force.name, filled)});
  }
  samples.values = std::move(values);
  for (int k = 0; k < kComponents; ++k) samples.labels.push_back(force.name);
  loads_.push_back(load);
}

void ExternalLoads::filter(const ExternalLoadsSetup& setup, double cutoff, TimeTable& samples) {
  for (std::size_t l = 0; l < loads_.size(); ++l) {
    const Load& load = loads_[l];
    if (!load.has_point) continue;
    if (load.frames.force_frame != load.frames.point_frame) {
      throw InputError({setup.path, load.line},
                       {fmt::format("external force '{}' cannot be filtered: its force and its "
                                    "point are given in different bodies' frames",
                                    samples.labels[l * kComponents]),
                        "", "", "Filter the recording before, or give both in ground."});
    }
    const auto first = static_cast<Eigen::Index>(l) * kComponents;
    for (Eigen::Index i = 0; i < samples.time.size(); ++i) {
      auto row = samples.values.row(i);
      const Eigen::Vector3d f = row.segment<3>(first), p = row.segment<3>(first + 3);
      row.segment<3>(first + 6) += p.cross(f);
      row.segment<3>(first + 3).setZero();
    }
  }
  try {
    samples = lowpass_with_padding(samples, cutoff);
  } catch (const std::invalid_argument& error) {
    throw InputError(
        data_source_,
        {fmt::format("the external loads cannot be filtered: {}", error.what()), "", "", ""});
  }
}

void ExternalLoads::fit(const TimeTable& samples) {
  const Eigen::Index rows = samples.time.size();
  time_ = samples.time;
  if (rows == 1) {
    terms_ = 1;
    coefficients_ = samples.values;
    return;
  }
  const int half_order = rows >= kSplineSamples ? 2 : 1;
  terms_ = 2 * half_order;
  coefficients_ = natural_spline_coefficients(samples.time, samples.values, half_order);
}

void ExternalLoads::require_coverage(double from, double to) const {
  if (loads_.empty()) return;
  const double slack = 0.5 * mean_step_;
  if (time_.size() == 1 || (from >= first_time_ - slack && to <= last_time_ + slack)) return;
  throw InputError(data_source_, {"the external loads do not cover the motion",
                                  fmt::format("{:.6g} to {:.6g} s", from, to),
                                  fmt::format("{:.6g} to {:.6g} s", first_time_, last_time_),
                                  "Choose a time range within the loads."});
}

ExternalLoads::Sample ExternalLoads::sample(int load, double t) const {
  Sample result = loads_[static_cast<std::size_t>(load)].frames;
  const auto above = std::upper_bound(time_.begin(), time_.end(), t) - time_.begin();
  const Eigen::Index last = std::max<Eigen::Index>(0, time_.size() - 2);
  const Eigen::Index i = std::clamp<Eigen::Index>(above - 1, 0, last);
  const double s = t - time_[i];
  Eigen::Matrix<double, 1, kComponents> value = Eigen::Matrix<double, 1, kComponents>::Zero();
  for (int k = terms_ - 1; k >= 0; --k) {
    value = value * s + coefficients_.row(terms_ * i + k).segment<kComponents>(load * kComponents);
  }
  result.force = value.segment<3>(0);
  result.point = value.segment<3>(3);
  result.torque = value.segment<3>(6);
  return result;
}

void ExternalLoads::add_body_forces(double t, const SimbodyModel& compiled,
                                    const SimTK::State& state,
                                    SimTK::Vector_<SimTK::SpatialVec>& F_B_W) const {
  const SimTK::SimbodyMatterSubsystem& matter = compiled.matter();
  const auto X_WB = [&](int body) -> const SimTK::Transform& {
    return matter.getMobilizedBody(compiled.body(body)).getBodyTransform(state);
  };
  for (int l = 0; l < size(); ++l) {
    const Sample load = sample(l, t);
    const SimTK::Rotation& R_WF = X_WB(load.force_frame).R();
    const SimTK::Vec3 f_W = R_WF * to_simtk(load.force);
    const SimTK::Vec3 p_WQ = X_WB(load.point_frame) * to_simtk(load.point);
    const SimTK::Vec3 p_BQ_W = p_WQ - X_WB(load.body).p();
    const SimTK::Vec3 moment_W = p_BQ_W % f_W + R_WF * to_simtk(load.torque);
    F_B_W[compiled.body(load.body)] += SimTK::SpatialVec(moment_W, f_W);
  }
}

}  // namespace sinew
