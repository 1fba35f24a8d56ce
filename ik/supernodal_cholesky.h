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
/// Allocates at construction only.
class SupernodalCholesky {
 public:
  /// `cliques`: sets of indices in [0, n) that are coupled with each other, in any order. Every
  /// diagonal entry is part of the pattern.
  SupernodalCholesky(int n, std::span<const std::vector<int>> cliques);

  /// Sets H to zero. Afterwards the caller adds to its lower triangle, within the pattern.
  void clear();
  Eigen::MatrixXd& matrix() { return H_; }
  const Eigen::MatrixXd& matrix() const { return H_; }

  /// Factorizes H + shift·E, with the rows and columns of `held` (n entries, 1: held) replaced by
  /// those of E. H stays as it is. Returns false if the matrix is not positive definite.
  bool factorize(double shift, std::span<const char> held);

  /// x ← (LLᵀ)⁻¹ x.
  void solve(Eigen::Ref<Eigen::VectorXd> x);

  int size() const { return static_cast<int>(H_.rows()); }
  /// Entries of L, the zeros within supernodes included.
  long nonzeros() const;
  /// Multiplications and additions of a factorization, as if all supernodes were eliminated
  /// column by column.
  double operations() const;

 private:
  struct Supernode {
    int first = 0, count = 0;          // columns
    int first_row = 0, row_count = 0;  // in rows_: those below the supernode
  };

  std::vector<std::vector<int>> analyse(std::span<const std::vector<int>> cliques) const;
  void gather(const Supernode& s, double shift, std::span<const char> held);
  bool eliminate(const Supernode& s);

  std::vector<Supernode> supernodes_;
  std::vector<int> rows_;  // ascending within a supernode
  Eigen::MatrixXd H_;      // lower triangle within the pattern; the rest is never touched
  Eigen::MatrixXd L_;      // likewise
  std::vector<double> panel_, product_, rhs_;
};

}  // namespace sinew
