#pragma once

#include <span>
#include <vector>

#include "server/core/linear/block_matrix.h"

namespace kerf::linear {

// Groups of about nine adjacent vertices, found from the pattern of a matrix alone. Vertices that no block couples,
// such as on the two sides of a cut, share a group only near the end of the cut.
class VertexAggregates {
 public:
  void find(const BlockMatrix& A);

  [[nodiscard]] int size() const { return static_cast<int>(roots_.size()); }
  // Group of vertex i, or -1 if it is coupled with no other vertex.
  [[nodiscard]] int of(int i) const { return of_[static_cast<std::size_t>(i)]; }
  // Members of a group, ascending.
  [[nodiscard]] std::span<const int> members(int group) const;
  // Vertex that the group was built around.
  [[nodiscard]] int root(int group) const { return roots_[static_cast<std::size_t>(group)]; }

 private:
  void found(const BlockMatrix& A);
  void join_neighbours(const BlockMatrix& A);
  void list_members();

  std::vector<int> of_;            // N
  std::vector<int> roots_;         // by group
  std::vector<int> member_begin_;  // number of groups + 1, into members_
  std::vector<int> members_;
};

}  // namespace kerf::linear
