#include "ik/supernodal_cholesky.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

// Joining two columns may add zeros up to this part of the joint columns: dense kernels make up for
// them.
constexpr double kZerosAllowed = 0.1;

using Map = Eigen::Map<Eigen::VectorXd>;
using ConstMap = Eigen::Map<const Eigen::VectorXd>;

// to[0 … length) −= Σ_k panel[k·height + offset …] · panel[k·height + pivot], four columns at once
// so that `to` is loaded and stored a quarter as often.
void subtract_columns(double* to, int length, const double* panel, int height, int count, int pivot,
                      int offset) {
  Map sum(to, length);
  const double* column = panel;
  int k = 0;
  for (; k + 3 < count; k += 4, column += 4 * static_cast<std::ptrdiff_t>(height)) {
    const double* const c1 = column + height;
    const double* const c2 = c1 + height;
    const double* const c3 = c2 + height;
    sum -= column[pivot] * ConstMap(column + offset, length) +
           c1[pivot] * ConstMap(c1 + offset, length) + c2[pivot] * ConstMap(c2 + offset, length) +
           c3[pivot] * ConstMap(c3 + offset, length);
  }
  for (; k < count; ++k, column += height) {
    sum -= column[pivot] * ConstMap(column + offset, length);
  }
}

}  // namespace

SupernodalCholesky::SupernodalCholesky(int n, std::span<const std::vector<int>> cliques)
    : n_(n), supernode_of_(static_cast<std::size_t>(n)) {
  join_columns(analyse(cliques));
  link_supernodes();
}

// Columns that share their pattern become supernodes.
void SupernodalCholesky::join_columns(const std::vector<std::vector<int>>& below) {
  int values = 0, highest = 0;
  for (int column = 0; column < n_;) {
    // Columns first … last share the pattern of the last one's rows below it.
    int last = column;
    std::size_t zeros = 0;
    while (last + 1 < n_ && !below[static_cast<std::size_t>(last)].empty() &&
           below[static_cast<std::size_t>(last)].front() == last + 1) {
      const std::size_t own = below[static_cast<std::size_t>(last)].size();
      const std::size_t joint = below[static_cast<std::size_t>(last) + 1].size() + 1;
      const auto columns = static_cast<std::size_t>(last + 1 - column);
      const std::size_t added = zeros + (joint - own) * columns;
      if (static_cast<double>(added) > kZerosAllowed * static_cast<double>(joint * (columns + 1))) {
        break;
      }
      zeros = added;
      ++last;
    }
    const std::vector<int>& rows = below[static_cast<std::size_t>(last)];
    Supernode s{.first = column, .count = last + 1 - column};
    s.first_row = static_cast<int>(rows_.size());
    s.height = s.count + static_cast<int>(rows.size());
    s.first_value = values;
    for (int own = column; own <= last; ++own) {
      supernode_of_[static_cast<std::size_t>(own)] = static_cast<int>(supernodes_.size());
      diagonal_.push_back(values + (own - column) * (s.height + 1));
      rows_.push_back(own);
    }
    rows_.insert(rows_.end(), rows.begin(), rows.end());
    values += s.count * s.height;
    highest = std::max(highest, s.height);
    supernodes_.push_back(s);
    column = last + 1;
  }
  H_.resize(static_cast<std::size_t>(values), 0.0);
  L_.resize(static_cast<std::size_t>(values), 0.0);
  column_.resize(static_cast<std::size_t>(highest));
}

// Where the products of each supernode's rows go.
void SupernodalCholesky::link_supernodes() {
  for (Supernode& s : supernodes_) {
    const int* const rows = rows_.data() + s.first_row;
    s.first_target = static_cast<int>(targets_.size());
    for (int i = s.count; i < s.height;) {
      Target target{supernode_of_[static_cast<std::size_t>(rows[i])], i, i,
                    static_cast<int>(places_.size())};
      const Supernode& to = supernodes_[static_cast<std::size_t>(target.supernode)];
      while (target.end < s.height && rows[target.end] < to.first + to.count) ++target.end;
      for (int k = i; k < s.height; ++k) places_.push_back(place_of(to, rows[k]));
      targets_.push_back(target);
      i = target.end;
    }
    s.target_count = static_cast<int>(targets_.size()) - s.first_target;
  }
}

// Of a row in the supernode's panel, −1 if it is not there.
int SupernodalCholesky::place_of(const Supernode& s, int row) const {
  const auto begin = rows_.begin() + s.first_row, end = begin + s.height;
  const auto found = std::lower_bound(begin, end, row);
  return found != end && *found == row ? static_cast<int>(found - begin) : -1;
}

int SupernodalCholesky::offset(int row, int column) const {
  const Supernode& s =
      supernodes_[static_cast<std::size_t>(supernode_of_[static_cast<std::size_t>(column)])];
  const int place = place_of(s, row);
  return place < 0 ? -1 : s.first_value + (column - s.first) * s.height + place;
}

// Rows below the diagonal of every column of L, ascending: the column's own entries and those of
// the columns whose first row it is (the elimination tree).
std::vector<std::vector<int>> SupernodalCholesky::analyse(
    std::span<const std::vector<int>> cliques) const {
  const auto n = static_cast<std::size_t>(n_);
  std::vector<std::vector<int>> below(n);
  std::vector<int> sorted, merged;
  const auto merge = [&](std::vector<int>& rows, auto begin, auto end) {
    merged.clear();
    std::set_union(rows.begin(), rows.end(), begin, end, std::back_inserter(merged));
    rows.swap(merged);
  };
  // A clique reaches every later column by way of its first one.
  for (const std::vector<int>& clique : cliques) {
    if (clique.empty()) continue;
    sorted = clique;
    std::sort(sorted.begin(), sorted.end());
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    merge(below[static_cast<std::size_t>(sorted.front())], sorted.begin() + 1, sorted.end());
  }
  for (std::size_t column = 0; column < n; ++column) {
    if (below[column].empty()) continue;
    const auto parent = static_cast<std::size_t>(below[column].front());
    merge(below[parent], below[column].begin() + 1, below[column].end());
  }
  return below;
}

void SupernodalCholesky::clear() { std::fill(H_.begin(), H_.end(), 0.0); }

double SupernodalCholesky::mean_diagonal() const {
  double sum = 0.0;
  for (const int at : diagonal_) sum += H_[static_cast<std::size_t>(at)];
  return sum / std::max(n_, 1);
}

// Replaces the held rows and columns of a panel by those of E.
void SupernodalCholesky::hold(const Supernode& s, std::span<const char> held) {
  const int* const rows = rows_.data() + s.first_row;
  double* const panel = L_.data() + s.first_value;
  for (int i = 0; i < s.height; ++i) {
    if (!held[static_cast<std::size_t>(rows[i])]) continue;
    for (int k = 0; k < s.count; ++k) panel[k * s.height + i] = 0.0;
    if (i >= s.count) continue;
    std::fill_n(panel + i * s.height, s.height, 0.0);
    panel[i * s.height + i] = 1.0;
  }
}

bool SupernodalCholesky::eliminate(const Supernode& s) {
  double* const panel = L_.data() + s.first_value;
  for (int j = 0; j < s.count; ++j) {
    double* const column = panel + j * s.height;
    subtract_columns(column + j, s.height - j, panel, s.height, j, j, j);
    if (!(column[j] > 0.0)) return false;
    Map(column + j, s.height - j) *= 1.0 / std::sqrt(column[j]);
  }
  for (int t = s.first_target; t < s.first_target + s.target_count; ++t) {
    const Target& target = targets_[static_cast<std::size_t>(t)];
    const Supernode& to = supernodes_[static_cast<std::size_t>(target.supernode)];
    const int* const places = places_.data() + target.first_place - target.begin;
    for (int i = target.begin; i < target.end; ++i) {
      const int length = s.height - i;
      std::fill_n(column_.data(), length, 0.0);
      subtract_columns(column_.data(), length, panel, s.height, s.count, i, i);
      double* const into = L_.data() + to.first_value + places[i] * to.height;
      for (int k = 0; k < length; ++k) into[places[i + k]] += column_[static_cast<std::size_t>(k)];
    }
  }
  return true;
}

bool SupernodalCholesky::factorize(double shift, std::span<const char> held) {
  L_ = H_;  // same size: copies without allocating
  for (const int at : diagonal_) L_[static_cast<std::size_t>(at)] += shift;
  if (std::find(held.begin(), held.end(), 1) != held.end()) {
    for (const Supernode& s : supernodes_) hold(s, held);
  }
  for (const Supernode& s : supernodes_) {
    if (!eliminate(s)) return false;
  }
  return true;
}

void SupernodalCholesky::add_product(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
  for (const Supernode& s : supernodes_) {
    const int* const rows = rows_.data() + s.first_row;
    for (int k = 0; k < s.count; ++k) {
      const double* const column = H_.data() + s.first_value + k * s.height;
      const int own = s.first + k;
      double sum = column[k] * x[own];
      for (int i = k + 1; i < s.height; ++i) {
        sum += column[i] * x[rows[i]];
        y[rows[i]] += column[i] * x[own];
      }
      y[own] += sum;
    }
  }
}

void SupernodalCholesky::forward(Eigen::Ref<Eigen::VectorXd> x, int first) {
  if (n_ == 0) return;
  const auto begin = supernodes_.begin() + supernode_of_[static_cast<std::size_t>(first)];
  for (const Supernode& s : std::span(begin, supernodes_.end())) {
    const double* const own = x.data() + s.first;
    if (std::all_of(own, own + s.count, [](double each) { return each == 0.0; })) continue;
    const int* const rows = rows_.data() + s.first_row + s.count;
    const double* const panel = L_.data() + s.first_value;
    const int rest = s.height - s.count;
    std::fill_n(column_.data(), rest, 0.0);
    for (int k = 0; k < s.count; ++k) {
      const double* const column = panel + k * s.height;
      const double value = x[s.first + k] /= column[k];
      for (int i = k + 1; i < s.count; ++i) x[s.first + i] -= value * column[i];
      Map(column_.data(), rest) += value * ConstMap(column + s.count, rest);
    }
    for (int i = 0; i < rest; ++i) x[rows[i]] -= column_[static_cast<std::size_t>(i)];
  }
}

void SupernodalCholesky::backward(Eigen::Ref<Eigen::VectorXd> x) {
  for (std::size_t n = supernodes_.size(); n-- > 0;) {
    const Supernode& s = supernodes_[n];
    const int* const rows = rows_.data() + s.first_row + s.count;
    const double* const panel = L_.data() + s.first_value;
    const int rest = s.height - s.count;
    for (int i = 0; i < rest; ++i) column_[static_cast<std::size_t>(i)] = x[rows[i]];
    for (int k = s.count - 1; k >= 0; --k) {
      const double* const column = panel + k * s.height;
      double sum = Map(column_.data(), rest).dot(ConstMap(column + s.count, rest));
      for (int i = k + 1; i < s.count; ++i) sum += column[i] * x[s.first + i];
      x[s.first + k] = (x[s.first + k] - sum) / column[k];
    }
  }
}

long SupernodalCholesky::nonzeros() const {
  long count = 0;
  for (const Supernode& s : supernodes_) {
    count += static_cast<long>(s.count) * (s.count + 1) / 2 +
             static_cast<long>(s.count) * (s.height - s.count);
  }
  return count;
}

double SupernodalCholesky::operations() const {
  double sum = 0.0;
  for (const Supernode& s : supernodes_) {
    for (int k = 0; k < s.count; ++k) {
      const double height = s.height - k;
      sum += height * height;
    }
  }
  return sum;
}

}  // namespace sinew
