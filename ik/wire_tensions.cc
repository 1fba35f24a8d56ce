#include "ik/wire_tensions.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

// Rounds in which whole blocks change sides although that left no fewer on the wrong one.
constexpr int kPatience = 5;

using ConstMap = Eigen::Map<const Eigen::VectorXd>;

}  // namespace

WireTensions::WireTensions(int unknowns, int wires)
    : place_(static_cast<std::size_t>(wires), -1),
      y_(unknowns),
      column_(Eigen::VectorXd::Zero(unknowns)) {
  const auto n = static_cast<std::size_t>(wires);
  const std::size_t entries = n * static_cast<std::size_t>(unknowns);
  for (std::vector<double>* each : {&weight_, &demand_, &tension_, &x_}) each->reserve(n);
  wires_.reserve(n);
  first_.reserve(n + 1);
  first_.push_back(0);
  is_active_.reserve(n);
  is_wrong_.reserve(n);
  active_.reserve(n);
  indices_.reserve(entries);
  values_.reserve(entries);
  products_.reserve(n * (n + 1) / 2);
  L_.reserve(n * (n + 1) / 2);
}

void WireTensions::begin(const Eigen::VectorXd& y) {
  y_ = y;
  for (const int wire : wires_) place_[static_cast<std::size_t>(wire)] = -1;
  wires_.clear();
  weight_.clear();
  demand_.clear();
  tension_.clear();
  first_.resize(1);
  indices_.clear();
  values_.clear();
  products_.clear();
  is_active_.clear();
  active_.clear();
  L_.clear();
  factored_ = 0;
}

void WireTensions::add(int wire, double excess, double weight, std::span<const int> indices,
                       std::span<const double> row, SupernodalCholesky& factor) {
  int first = static_cast<int>(column_.size());
  for (std::size_t k = 0; k < row.size(); ++k) {
    column_[indices[k]] = row[k];
    first = std::min(first, indices[k]);
  }
  if (!row.empty()) factor.forward(column_, first);
  double demand = excess, square = 1.0 / weight;
  const std::size_t begin = indices_.size();
  for (Eigen::Index k = first; k < column_.size(); ++k) {
    const double c = column_[k];
    if (c == 0.0) continue;
    indices_.push_back(static_cast<int>(k));
    values_.push_back(c);
    demand += c * y_[k];
    square += c * c;
  }
  for (std::size_t i = 0; i + 1 < first_.size(); ++i) {
    double sum = 0.0;
    for (std::size_t k = first_[i]; k < first_[i + 1]; ++k)
      sum += values_[k] * column_[indices_[k]];
    products_.push_back(sum);
  }
  products_.push_back(square);
  for (std::size_t k = begin; k < indices_.size(); ++k) column_[indices_[k]] = 0.0;
  first_.push_back(indices_.size());
  place_[static_cast<std::size_t>(wire)] = static_cast<int>(wires_.size());
  wires_.push_back(wire);
  weight_.push_back(weight);
  demand_.push_back(demand);
  tension_.push_back(0.0);
  is_active_.push_back(0);
  set_active(wires_.size() - 1, true);
}

void WireTensions::set_active(std::size_t i, bool active) {
  is_active_[i] = active;
  if (active) {
    active_.push_back(i);
    return;
  }
  const auto found = std::find(active_.begin(), active_.end(), i);
  factored_ = std::min(factored_, static_cast<std::size_t>(found - active_.begin()));
  active_.erase(found);
}

// Tensions of the active wires, with the others slack.
void WireTensions::solve_active() {
  const std::size_t n = active_.size();
  L_.resize(factored_ * (factored_ + 1) / 2);
  for (std::size_t i = factored_; i < n; ++i) {
    const std::size_t row = L_.size();
    double square = product(active_[i], active_[i]);
    for (std::size_t k = 0; k < i; ++k) {
      const std::size_t other = k * (k + 1) / 2;
      const auto length = static_cast<Eigen::Index>(k);
      const double dot = ConstMap(L_.data() + row, length).dot(ConstMap(L_.data() + other, length));
      L_.push_back((product(active_[i], active_[k]) - dot) / L_[other + k]);
      square -= L_.back() * L_.back();
    }
    // Two wires along one line are told apart by 1/w alone.
    L_.push_back(std::sqrt(std::max(square, 1e-3 / weight_[active_[i]])));
  }
  factored_ = n;
  x_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double* const row = L_.data() + i * (i + 1) / 2;
    const auto length = static_cast<Eigen::Index>(i);
    x_[i] = (demand_[active_[i]] - ConstMap(row, length).dot(ConstMap(x_.data(), length))) / row[i];
  }
  for (std::size_t i = n; i-- > 0;) {
    const double* const row = L_.data() + i * (i + 1) / 2;
    x_[i] /= row[i];
    for (std::size_t k = 0; k < i; ++k) x_[k] -= x_[i] * row[k];
  }
  std::fill(tension_.begin(), tension_.end(), 0.0);
  for (std::size_t i = 0; i < n; ++i) tension_[active_[i]] = x_[i];
}

void WireTensions::solve() {
  std::size_t fewest = wires_.size() + 1;
  int patience = kPatience;
  is_wrong_.assign(wires_.size(), 0);
  // The fallback visits no set twice; far fewer rounds than this are seen.
  const std::size_t most = 50 + 4 * wires_.size();
  for (std::size_t round = 0; round < most; ++round) {
    solve_active();
    std::size_t wrong = 0, last = 0;
    for (std::size_t i = 0; i < wires_.size(); ++i) {
      double margin = tension_[i];
      if (!is_active_[i]) {
        margin = -demand_[i];  // z
        for (const std::size_t k : active_) margin += product(i, k) * tension_[k];
      }
      is_wrong_[i] = margin < 0.0;
      if (!is_wrong_[i]) continue;
      ++wrong;
      last = i;
    }
    if (wrong == 0) return;
    if (wrong < fewest) {
      fewest = wrong;
      patience = kPatience;
    } else if (patience > 0) {
      --patience;
    }
    for (std::size_t i = 0; i < wires_.size(); ++i) {
      if (is_wrong_[i] && (patience > 0 || i == last)) set_active(i, !is_active_[i]);
    }
  }
  for (double& f : tension_) f = std::max(f, 0.0);
}

double WireTensions::energy() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < wires_.size(); ++i) sum += tension_[i] * tension_[i] / weight_[i];
  return 0.5 * sum;
}

void WireTensions::step(SupernodalCholesky& factor, Eigen::VectorXd& d) const {
  d = y_;
  for (std::size_t i = 0; i < wires_.size(); ++i) {
    if (tension_[i] == 0.0) continue;
    for (std::size_t k = first_[i]; k < first_[i + 1]; ++k) {
      d[indices_[k]] -= tension_[i] * values_[k];
    }
  }
  factor.backward(d);
}

}  // namespace sinew
