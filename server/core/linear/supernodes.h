#pragma once

#include <span>
#include <vector>

#include "server/core/linear/block_matrix.h"

namespace kerf::linear {

// Symbolic Cholesky factorisation of a symmetric matrix of blocks. It finds an order of the vertices that leaves the
// factor sparse (approximate minimum degree: Amestoy, Davis, Duff 1996), and its supernodes. A supernode is a run of
// columns in that order that share their rows below the run. Rows that differ a little are filled up with explicit
// zeros. Children come before parents (a postorder).
class Supernodes {
 public:
  void analyse(const BlockMatrix& A);

  [[nodiscard]] int size() const { return static_cast<int>(first_.size()) - 1; }
  [[nodiscard]] int num_vertices() const { return static_cast<int>(old_from_new_.size()); }
  // Vertices [first(s), first(s) + width(s)), in the new order, are the columns of supernode s.
  [[nodiscard]] int first(int s) const { return first_[static_cast<std::size_t>(s)]; }
  [[nodiscard]] int width(int s) const { return first(s + 1) - first(s); }
  // Rows of supernode s in the new order, ascending: its own columns, then the rows below them.
  [[nodiscard]] std::span<const int> rows(int s) const {
    const auto i = static_cast<std::size_t>(s);
    return {rows_.data() + rows_begin_[i], rows_.data() + rows_begin_[i + 1]};
  }
  // Parent of supernode s in the elimination tree; -1 for a root.
  [[nodiscard]] int parent(int s) const { return parent_[static_cast<std::size_t>(s)]; }
  [[nodiscard]] std::span<const int> children(int s) const {
    const auto i = static_cast<std::size_t>(s);
    return {children_.data() + children_begin_[i], children_.data() + children_begin_[i + 1]};
  }
  // For each row of s below its own columns, the index of that row among the rows of the parent.
  [[nodiscard]] std::span<const int> rows_in_parent(int s) const {
    const auto i = static_cast<std::size_t>(s);
    return {rows_in_parent_.data() + rows_begin_[i] + width(s), rows_in_parent_.data() + rows_begin_[i + 1]};
  }
  [[nodiscard]] int new_from_old(int v) const { return new_from_old_[static_cast<std::size_t>(v)]; }
  [[nodiscard]] int old_from_new(int v) const { return old_from_new_[static_cast<std::size_t>(v)]; }

 private:
  void order(const BlockMatrix& A);
  // Sets tree_ to the parents of columns in the elimination tree; -1 for roots.
  void find_tree(const BlockMatrix& A);
  void postorder();
  // Sets count_ to the number of blocks of each column of the factor, including the diagonal.
  void count_entries(const BlockMatrix& A);
  void find_supernodes();
  void find_rows(const BlockMatrix& A);

  std::vector<int> new_from_old_, old_from_new_;
  std::vector<int> tree_;   // by column
  std::vector<int> count_;  // by column
  std::vector<int> first_;
  std::vector<int> rows_begin_, rows_, rows_in_parent_;
  std::vector<int> parent_, children_begin_, children_;
};

}  // namespace kerf::linear
