#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "ik/supernodal_cholesky.h"

namespace sinew {

/// Minimizes a quadratic model that wires bend,
///   m(d) = gᵀd + ½ dᵀHd + ½ Σ wᵢ max(0, εᵢ + jᵢᵀd)²,
/// by the tensions fᵢ = wᵢ max(0, εᵢ + jᵢᵀd), without the wires in H: Hd = −g − Σ fᵢjᵢ, so that
/// with H = LLᵀ, y = −L⁻¹g and cᵢ = L⁻¹jᵢ the tensions are those f ≥ 0 for which
///   z = (CᵀC + W⁻¹) f − ε − Cᵀy ≥ 0 and fᵀz = 0,
/// a linear complementarity problem in as many unknowns as there are wires that may become taut: a
/// few dozen of a thousand. Solved by block principal pivoting, which finds the exact set in few
/// rounds and has a fallback that always ends (Júdice & Pires 1994, Computers Ops Res 21:587-596).
///
/// Unknowns are in the order of the factor. Allocates at construction only: room for all wires at
/// once, which the system hands out as far as it is used.
class WireTensions {
 public:
  WireTensions(int unknowns, int wires);

  /// Forgets all wires; y as above.
  void begin(const Eigen::VectorXd& y);

  /// Adds a wire: its excess ε [m] at d = 0, its weight, and its row j, whose entry k belongs to
  /// unknown indices[k]. A wire may be added once.
  void add(int wire, double excess, double weight, std::span<const int> indices,
           std::span<const double> row, SupernodalCholesky& factor);
  bool has(int wire) const { return place_[static_cast<std::size_t>(wire)] >= 0; }

  /// Adds to the excess of a wire, if it was added.
  void lengthen(int wire, double length) {
    const int place = place_[static_cast<std::size_t>(wire)];
    if (place >= 0) demand_[static_cast<std::size_t>(place)] += length;
  }

  /// The tensions of the wires that were added.
  void solve();
  double tension(int wire) const {
    const int place = place_[static_cast<std::size_t>(wire)];
    return place < 0 ? 0.0 : tension_[static_cast<std::size_t>(place)];
  }
  /// ½ Σ f²/w: what the wires have stored at the minimum.
  double energy() const;

  /// d = L⁻ᵀ(y − C f).
  void step(SupernodalCholesky& factor, Eigen::VectorXd& d) const;

  int count() const { return static_cast<int>(wires_.size()); }

 private:
  double product(std::size_t i, std::size_t k) const {  // of CᵀC + W⁻¹
    return i < k ? products_[k * (k + 1) / 2 + i] : products_[i * (i + 1) / 2 + k];
  }
  void solve_active();
  void set_active(std::size_t i, bool active);

  std::vector<int> place_;  // wires of the problem: where among those added, −1: nowhere
  std::vector<int> wires_;  // that were added; all below are of these
  std::vector<double> weight_, demand_, tension_;  // demand: ε + cᵀy
  std::vector<std::size_t> first_;  // of c in indices_ and values_; one more at the end
  std::vector<int> indices_;        // where c is not zero
  std::vector<double> values_;
  std::vector<double> products_;            // lower triangle of CᵀC + W⁻¹, row by row
  std::vector<char> is_active_, is_wrong_;  // wrong: the other way round than it has to be
  std::vector<std::size_t> active_;         // taut ones; factored in this order
  std::vector<double> L_, x_;               // of the active products: rows one after another
  std::size_t factored_ = 0;                // rows of L_ that are right
  Eigen::VectorXd y_, column_;
};

}  // namespace sinew
