#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/linear/block_matrix.h"
#include "server/core/linear/dense_kernels.h"
#include "server/core/linear/goes_on.h"
#include "server/core/linear/lanes16.h"
#include "server/core/linear/supernodes.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// L L^T = P A P^T of a symmetric matrix of 3x3 blocks by the multifrontal method (Duff, Reid 1983; Davis 2006, Direct
// Methods for Sparse Linear Systems): columns of equal pattern are factored together as dense panels, and what they
// contribute to others is handed up the elimination tree. T: float or double.
template <typename T>
class SupernodalCholesky {
 public:
  // Takes the sparsity pattern; allocates all that the others need. Memory is not touched before the first factor.
  void analyse(const BlockMatrix& A);
  // The same with what another one, of whatever precision, has found of the same pattern.
  void analyse(const BlockMatrix& A, std::shared_ptr<const Supernodes> supernodes);
  [[nodiscard]] const std::shared_ptr<const Supernodes>& supernodes() const { return supernodes_; }
  // Factorisations to come ask `goes_on` once a supernode; one that it ends has failed.
  void heed(const GoesOn* goes_on) { heed_.set(goes_on); }
  // Of Q^T A Q, Q having the 3x3 blocks of `frames` on its diagonal, or A itself where it is empty. A has the pattern
  // that was analysed. False: A was found not positive definite, or, where `rule` replaces small pivots, not finite, or
  // it was ended; no factor is left.
  bool factorise(const BlockMatrix& A, std::span<const Eigen::Matrix3d> frames, PivotRule<T>& rule);
  // Solves Q^T A Q x = b for the last factor; x, b: 3 x N, may be the same.
  void solve(const mesh::VertexField& b, mesh::VertexField& x);

  // Of one factorisation; of one solve.
  [[nodiscard]] double factor_flops() const { return factor_flops_; }
  [[nodiscard]] double solve_flops() const { return 4.0 * static_cast<double>(num_entries_); }

 private:
  using Storage = std::vector<Lanes16<T>>;

  [[nodiscard]] PanelView<T> panel(int s) { return view(panels_, panel_begin_, s, width(s)); }
  [[nodiscard]] std::size_t width(int s) const { return 3 * static_cast<std::size_t>(supernodes_->width(s)); }
  [[nodiscard]] std::size_t rows(int s) const { return 3 * supernodes_->rows(s).size(); }
  PanelView<T> view(Storage& storage, const std::vector<std::size_t>& begin, int s, std::size_t width);

  void assemble(const BlockMatrix& A, std::span<const Eigen::Matrix3d> frames, int s);
  // Adds what child c hands up to the front of s.
  void extend_add(int c, int s);

  Heed heed_;
  std::shared_ptr<const Supernodes> supernodes_;
  std::vector<std::size_t> panel_begin_;          // of each supernode in panels_, in units of Lanes16
  std::vector<std::size_t> update_begin_;         // of what it hands up, in updates_: a stack
  std::size_t scratch_begin_ = 0;                 // behind the stack, where updates are made
  std::size_t num_panels_ = 0, num_updates_ = 0;  // Lanes16 of panels_, updates_
  Storage panels_, updates_;
  std::vector<T> diagonal_;  // 3 N, of the matrix, in the order of elimination
  std::vector<T> work_;      // 3 N, a right-hand side in that order
  Storage front_;            // one front's part of it
  std::vector<int> place_;   // of a vertex in the front that is being assembled
  double factor_flops_ = 0.0;
  std::size_t num_entries_ = 0;  // of L
};

}  // namespace kerf::fem
