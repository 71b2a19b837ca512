#include "server/core/mesh/piece_split.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "server/base/sort_unique.h"
#include "server/core/mesh/id_map.h"

namespace kerf::mesh {
namespace {

class ComponentGrowth {
 public:
  ComponentGrowth(const TriangleMesh& mesh, std::span<const TriangleId> seeds) : mesh_(mesh) {
    for (const TriangleId t : seeds) pieces_.push_back(mesh.piece(t));
    sort_unique(pieces_);
    num_open_.assign(pieces_.size(), 0);
    for (const TriangleId t : seeds) {
      if (group_of_.has(t)) continue;
      const auto index = static_cast<std::int32_t>(groups_.size());
      group_of_.add(t, index);
      groups_.push_back({{t}, {t}, 0, index, piece_index(t)});
      ++num_open_[groups_.back().piece];
      active_.push_back(index);
    }
  }

  std::vector<std::vector<TriangleId>> run() {
    std::vector<std::vector<TriangleId>> finished;
    while (!active_.empty()) {
      std::vector<std::int32_t> still_active;
      for (const std::int32_t index : active_) {
        if (groups_[index].parent != index || num_open_[groups_[index].piece] <= 1) continue;
        const std::int32_t grown = grow(index);
        if (groups_[grown].next == groups_[grown].frontier.size()) {
          --num_open_[groups_[grown].piece];
          finished.push_back(std::move(groups_[grown].members));
        } else if (grown == index) {
          still_active.push_back(index);
        }
      }
      active_ = std::move(still_active);
    }
    return finished;
  }

 private:
  struct Group {
    std::vector<TriangleId> members;
    std::vector<TriangleId> frontier;  // from index `next` on: members whose neighbours were not visited yet
    std::size_t next;
    std::int32_t parent;  // index of this group, or of the group it was merged into
    std::size_t piece;    // index into pieces_
  };

  [[nodiscard]] std::size_t piece_index(TriangleId t) const {
    return static_cast<std::size_t>(std::lower_bound(pieces_.begin(), pieces_.end(), mesh_.piece(t)) - pieces_.begin());
  }

  std::int32_t root(std::int32_t index) {
    while (groups_[index].parent != index) {
      groups_[index].parent = groups_[groups_[index].parent].parent;
      index = groups_[index].parent;
    }
    return index;
  }

  // Visits the neighbours of one slot of the group. Returns the group that the slot belongs to afterwards.
  std::int32_t grow(std::int32_t index) {
    Group& growing = groups_[index];
    const TriangleId t = growing.frontier[growing.next++];  // breadth first, so that groups on both sides of a tip meet
                                                            // soon
    for (int k = 0; k < 3; ++k) {
      const TriangleId n = mesh_.neighbour(t, k);
      if (n == kNone) continue;
      if (!group_of_.has(n)) {
        group_of_.add(n, index);
        groups_[index].members.push_back(n);
        groups_[index].frontier.push_back(n);
      } else if (root(group_of_.get(n)) != index) {
        index = merge(index, root(group_of_.get(n)));
      }
    }
    return index;
  }

  std::int32_t merge(std::int32_t a, std::int32_t b) {
    if (groups_[a].members.size() < groups_[b].members.size()) std::swap(a, b);
    Group& kept = groups_[a];
    Group& gone = groups_[b];
    kept.members.insert(kept.members.end(), gone.members.begin(), gone.members.end());
    kept.frontier.insert(kept.frontier.end(), gone.frontier.begin() + static_cast<std::ptrdiff_t>(gone.next),
                         gone.frontier.end());
    gone = {{}, {}, 0, a, gone.piece};
    --num_open_[kept.piece];
    return a;
  }

  const TriangleMesh& mesh_;
  IdMap group_of_;  // slot -> group that reached it first; root() gives the group that it belongs to now
  std::vector<Group> groups_;
  std::vector<std::int32_t> active_;
  std::vector<std::int32_t> pieces_;  // pieces with a seed, sorted
  std::vector<int> num_open_;         // by index into pieces_: groups that still grow, neither complete nor merged away
};

}  // namespace

std::vector<std::vector<TriangleId>> split_off_components(const TriangleMesh& mesh, std::span<const TriangleId> seeds) {
  return ComponentGrowth(mesh, seeds).run();
}

}  // namespace kerf::mesh
