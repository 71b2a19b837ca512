#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/base/stop_condition.h"
#include "server/core/linear/block_matrix.h"
#include "server/core/linear/dense_kernels.h"
#include "server/core/linear/lanes16.h"
#include "server/core/linear/supernodes.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::linear {

// Factors L L^T = P A P^T of a symmetric matrix of 3x3 blocks by the multifrontal method (Duff, Reid 1983; Davis 2006,
// Direct Methods for Sparse Linear Systems). Columns of equal pattern, a supernode, are factored together as a dense
// panel. The front of a supernode is the dense matrix over all its rows: the panel and the update matrix below it. The
// update matrix holds the contributions to later columns, and is passed up the elimination tree. T is float or double.
template <typename T>
class SupernodalCholesky {
 public:
  // Takes the sparsity pattern and allocates all storage. Memory is not touched before the first factorisation.
  void analyse(const BlockMatrix& A);
  // Takes the sparsity pattern and reuses `supernodes`, its symbolic factorisation by another object of any precision.
  void analyse(const BlockMatrix& A, std::shared_ptr<const Supernodes> supernodes);
  [[nodiscard]] const std::shared_ptr<const Supernodes>& supernodes() const { return supernodes_; }
  // Sets the stop condition, polled once a supernode. A factorisation that it ends has failed.
  void set_stop_condition(const StopCondition* stop) { stop_.set(stop); }
  // Factors Q^T A Q, where Q has the 3x3 blocks of `frames` on its diagonal. If `frames` is empty it factors A itself.
  // A has the analysed pattern. Returns false, with no factor left, if A was found not positive definite or the stop
  // condition ended it. If `rule` replaces small pivots, factorise() fails only at the stop condition, or for numbers
  // that PivotRule cannot replace.
  bool factorise(const BlockMatrix& A, std::span<const Eigen::Matrix3d> frames, PivotRule<T>& rule);
  // Solves Q^T A Q x = b with the last factor. x and b are 3 x N and may be the same.
  void solve(const VertexField& b, VertexField& x);

  // Floating-point operations of one factorisation and of one solve.
  [[nodiscard]] double factor_flops() const { return factor_flops_; }
  [[nodiscard]] double solve_flops() const { return 4.0 * static_cast<double>(num_entries_); }

 private:
  using Storage = std::vector<Lanes16<T>>;

  [[nodiscard]] PanelView<T> panel(int s) { return view(panels_, panel_begin_, s, width(s)); }
  [[nodiscard]] std::size_t width(int s) const { return 3 * static_cast<std::size_t>(supernodes_->width(s)); }
  [[nodiscard]] std::size_t rows(int s) const { return 3 * supernodes_->rows(s).size(); }
  PanelView<T> view(Storage& storage, const std::vector<std::size_t>& begin, int s, std::size_t width);

  void assemble(const BlockMatrix& A, std::span<const Eigen::Matrix3d> frames, int s);
  // Adds the update matrix of child c to the front of s.
  void extend_add(int c, int s);

  StopPoll stop_;
  std::shared_ptr<const Supernodes> supernodes_;
  std::vector<std::size_t> panel_begin_;          // of each supernode in panels_, in units of Lanes16
  std::vector<std::size_t> update_begin_;         // of the update matrix of each supernode in updates_, a stack
  std::size_t scratch_begin_ = 0;                 // behind the stack, where updates are computed
  std::size_t num_panels_ = 0, num_updates_ = 0;  // Lanes16 of panels_, updates_
  Storage panels_, updates_;
  std::vector<T> diagonal_;  // 3 N, diagonal of the matrix in the order of elimination
  std::vector<T> work_;      // 3 N, a right-hand side in that order
  Storage front_;            // the entries of a right-hand side at the rows of one front
  std::vector<int> place_;   // place of a vertex in the front being assembled
  double factor_flops_ = 0.0;
  std::size_t num_entries_ = 0;  // entries of L
};

}  // namespace kerf::linear
