#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

namespace sinew {

/// Cholesky factorization H = LLᵀ of a sparse symmetric matrix with a fixed pattern, for matrices
/// that are factorized anew at every iteration: the pattern is analysed once, and columns with the
/// same pattern below them are eliminated together with dense kernels (supernodes; Ng & Peyton
/// 1993, SIAM J Sci Comput 14:1034-1056). Columns are eliminated in the order given, no other is
/// sought: of a kinematic tree in reverse order, links after their children, none is needed.
///
/// A supernode's columns stand together as one dense panel, rows of the pattern only, so that the
/// 15 thousand entries of the whole body's matrix fill 120 kB instead of the 2.7 MB of a square
/// one. Allocates at construction only.
class SupernodalCholesky {
 public:
  /// `cliques`: sets of indices in [0, n) that are coupled with each other, in any order. Every
  /// diagonal entry is part of the pattern.
  SupernodalCholesky(int n, std::span<const std::vector<int>> cliques);

  /// Where the entry of H's lower triangle stands in values(); −1 outside the pattern. row ≥
  /// column.
  int offset(int row, int column) const;

  /// The entries of H, which the caller adds to.
  std::span<double> values() { return H_; }

  /// Sets H to zero.
  void clear();
  double mean_diagonal() const;

  /// Factorizes H + shift·E, with the rows and columns of `held` (n entries, 1: held) replaced by
  /// those of E. H stays as it is. Returns false if the matrix is not positive definite.
  bool factorize(double shift, std::span<const char> held);

  /// y += H x.
  void add_product(const Eigen::VectorXd& x, Eigen::VectorXd& y) const;

  /// x ← (LLᵀ)⁻¹ x.
  void solve(Eigen::Ref<Eigen::VectorXd> x) {
    forward(x);
    backward(x);
  }
  /// x ← L⁻¹ x. Entries before `first` must be zero; they and what is off the others' way up the
  /// elimination tree cost next to nothing.
  void forward(Eigen::Ref<Eigen::VectorXd> x, int first = 0);
  /// x ← L⁻ᵀ x.
  void backward(Eigen::Ref<Eigen::VectorXd> x);

  int size() const { return n_; }
  /// Entries of L, the zeros within supernodes included.
  long nonzeros() const;
  /// Multiplications and additions of a factorization, as if all supernodes were eliminated
  /// column by column.
  double operations() const;

 private:
  struct Supernode {
    int first = 0, count = 0;  // columns
    int first_row = 0;         // in rows_: the columns themselves, then the rows below
    int height = 0;            // of the panel: count and the rows below
    int first_value = 0;       // in H_ and L_: the panel, column after column
    int first_target = 0, target_count = 0;  // in targets_
  };
  // A supernode that another one's rows reach: which of them are its columns, and where these and
  // all later ones stand in its panel.
  struct Target {
    int supernode;
    int begin, end;   // rows of the source's panel
    int first_place;  // in places_, from row `begin` to the source's last
  };

  std::vector<std::vector<int>> analyse(std::span<const std::vector<int>> cliques) const;
  void join_columns(const std::vector<std::vector<int>>& below);
  void link_supernodes();
  int place_of(const Supernode& s, int row) const;
  void hold(const Supernode& s, std::span<const char> held);
  bool eliminate(const Supernode& s);

  int n_;
  std::vector<Supernode> supernodes_;
  std::vector<int> supernode_of_;  // columns
  std::vector<int> rows_;          // ascending within a supernode
  std::vector<Target> targets_;
  std::vector<int> places_;
  std::vector<int> diagonal_;  // columns: where the diagonal entry stands
  std::vector<double> H_, L_;
  std::vector<double> column_;  // of a panel's height
};

}  // namespace sinew
