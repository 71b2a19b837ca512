#pragma once

#include <span>
#include <vector>

#include "server/core/linear/block_matrix.h"

namespace kerf::fem {

// Vertices in groups of some nine that lie together, found from the pattern of a matrix alone: what no block couples,
// such as the two sides of a cut, is in one group only where a way round the end of the cut is short.
class VertexAggregates {
 public:
  void find(const BlockMatrix& A);

  [[nodiscard]] int size() const { return static_cast<int>(roots_.size()); }
  // The group of vertex i, or -1: nothing is coupled with it.
  [[nodiscard]] int of(int i) const { return of_[static_cast<std::size_t>(i)]; }
  // Ascending.
  [[nodiscard]] std::span<const int> members(int group) const;
  // The member that the group was built around.
  [[nodiscard]] int root(int group) const { return roots_[static_cast<std::size_t>(group)]; }

 private:
  void found(const BlockMatrix& A);
  void join_neighbours(const BlockMatrix& A);
  void list_members();

  std::vector<int> of_;            // N
  std::vector<int> roots_;         // one a group
  std::vector<int> member_begin_;  // one a group and one more, into members_
  std::vector<int> members_;
};

}  // namespace kerf::fem
