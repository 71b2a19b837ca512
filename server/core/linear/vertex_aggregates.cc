#include "server/core/linear/vertex_aggregates.h"

#include <algorithm>
#include <utility>

#include "server/base/as_index.h"

namespace kerf::linear {
namespace {

constexpr int kNoGroup = -1;

int row_size(const BlockMatrix& A, int i) {
  return A.row_end(i) - A.row_begin(i);
}

// Returns the number of columns that rows i and j share.
int num_common(const BlockMatrix& A, int i, int j) {
  int common = 0;
  int p = A.row_begin(i);
  int q = A.row_begin(j);
  while (p < A.row_end(i) && q < A.row_end(j)) {
    const int difference = A.column(p) - A.column(q);
    common += difference == 0 ? 1 : 0;
    p += difference <= 0 ? 1 : 0;
    q += difference >= 0 ? 1 : 0;
  }
  return common;
}

}  // namespace

void VertexAggregates::find(const BlockMatrix& A) {
  of_.assign(as_index(A.num_rows()), kNoGroup);
  roots_.clear();
  found(A);
  join_neighbours(A);
  list_members();
}

// Founds a group at each vertex whose near neighbours are all in no group yet. Near are the six that share the most
// columns with it. With bending a row reaches two edges far, so whole rows would make groups of some 25 vertices, which
// need more iterations.
void VertexAggregates::found(const BlockMatrix& A) {
  constexpr std::size_t kNear = 6;
  std::vector<std::pair<int, int>> near;  // minus columns in common, neighbour
  for (int i = 0; i < A.num_rows(); ++i) {
    if (of_[as_index(i)] != kNoGroup || row_size(A, i) == 1) continue;
    near.clear();
    for (int at = A.row_begin(i); at < A.row_end(i); ++at) {
      const int j = A.column(at);
      if (j != i) near.emplace_back(-num_common(A, i, j), j);
    }
    std::sort(near.begin(), near.end());
    near.resize(std::min(near.size(), kNear));
    if (!std::all_of(near.begin(), near.end(), [&](const auto& n) { return of_[as_index(n.second)] == kNoGroup; }))
      continue;
    of_[as_index(i)] = size();
    for (const auto& [common, j] : near) of_[as_index(j)] = size();
    roots_.push_back(i);
  }
}

// Adds each remaining vertex to the group that has most of the vertices of its row. If none of them is in a group, a
// new one of the ungrouped vertices of the row is founded.
void VertexAggregates::join_neighbours(const BlockMatrix& A) {
  const std::vector<int> before = of_;
  for (int i = 0; i < A.num_rows(); ++i) {
    if (of_[as_index(i)] != kNoGroup || row_size(A, i) == 1) continue;
    int most = 0;
    for (int at = A.row_begin(i); at < A.row_end(i); ++at) {
      const int group = before[as_index(A.column(at))];
      if (group == kNoGroup) continue;
      int votes = 0;
      for (int other = A.row_begin(i); other < A.row_end(i); ++other) {
        votes += before[as_index(A.column(other))] == group ? 1 : 0;
      }
      if (votes <= most) continue;
      most = votes;
      of_[as_index(i)] = group;
    }
    if (most > 0) continue;
    for (int at = A.row_begin(i); at < A.row_end(i); ++at) {
      int& group = of_[as_index(A.column(at))];
      if (group == kNoGroup) group = size();
    }
    roots_.push_back(i);
  }
}

void VertexAggregates::list_members() {
  member_begin_.assign(roots_.size() + 1, 0);
  for (const int group : of_) {
    if (group != kNoGroup) ++member_begin_[as_index(group) + 1];
  }
  for (std::size_t g = 0; g < roots_.size(); ++g) member_begin_[g + 1] += member_begin_[g];
  members_.resize(as_index(member_begin_.back()));
  std::vector<int> next = member_begin_;
  for (std::size_t i = 0; i < of_.size(); ++i) {
    if (of_[i] != kNoGroup) members_[as_index(next[as_index(of_[i])]++)] = static_cast<int>(i);
  }
}

std::span<const int> VertexAggregates::members(int group) const {
  const int begin = member_begin_[as_index(group)];
  return {members_.data() + begin, as_index(member_begin_[as_index(group) + 1] - begin)};
}

}  // namespace kerf::linear
