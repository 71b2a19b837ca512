#include "server/core/cut/bisection.h"

#include <array>
#include <deque>
#include <vector>

#include "server/core/mesh/lattice_geometry.h"
#include "server/core/mesh/triangle_shape.h"

namespace kerf::cut {

using mesh::kNone;
using mesh::LatticePoint;
using mesh::next_corner;
using mesh::PointId;
using mesh::previous_corner;
using mesh::TriangleId;

namespace {

void lock_element(mesh::MeshEditor& editor, TriangleId t) {
  for (int k = 0; k < 3; ++k) editor.lock_edge(t, k, mesh::kLockOriginal);
}

// An ill-shaped triangle in the queue. It is stale if the slot holds other corners now.
struct Waiting {
  TriangleId triangle = kNone;
  std::array<PointId, 3> points{};
};

class Bisection {
 public:
  Bisection(mesh::MeshEditor& editor, const PathScale& scale, const BisectionConfig& config)
      : editor_(editor), mesh_(editor.mesh()), scale_(scale), config_(config) {}

  Result<mesh::RefinementCounts> run(std::span<const TriangleId> seeds) {
    for (const TriangleId t : seeds) consider(t);
    while (!container_.empty()) {
      const Waiting next = container_.front();
      container_.pop_front();
      if (mesh_.points(next.triangle) != next.points) continue;
      if (counts_.insertions >= config_.max_insertions) {
        counts_.stopped = true;
        break;
      }
      bisect(next.triangle);
      if (editor_.budget_exhausted()) {
        return resource_exhausted(
            "CUT_ELEMENT_BUDGET",
            "bisecting ill-shaped triangles needs more new triangles than allowed; shorten the cut, or raise "
            "max_new_triangles",
            "cut.max_new_triangles");
      }
    }
    return counts_;
  }

 private:
  void consider(TriangleId t) {
    if (mesh_.is_solid(t) && is_ill_shaped(t)) container_.push_back({t, mesh_.points(t)});
  }

  [[nodiscard]] bool is_ill_shaped(TriangleId t) const {
    const mesh::TriangleShape shape = shape_of(corners_of(mesh_, t));
    if (shape.longest <= config_.limits.edge_ratio * shape.shortest || shape.longest <= 2.0 * config_.length_floor)
      return false;
    const double length = scale_.edge_length(mesh_.point_position(mesh_.points(t)[0])) / mesh_.lattice().spacing;
    return shape.longest * shape.smallest_height > config_.limits.area_ratio * length * length;  // twice the areas
  }

  void bisect(TriangleId t) {
    int longest = 0;
    double squared_longest = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double squared =
          squared_distance(mesh_.at(mesh_.points(t)[next_corner(k)]), mesh_.at(mesh_.points(t)[previous_corner(k)]));
      if (squared <= squared_longest) continue;
      squared_longest = squared;
      longest = k;
    }
    const TriangleId across = mesh_.welded_neighbour(t, longest);
    // The triangle beyond may be an element that the path does not cross. Locks its edges, so that its new triangles
    // stay inside it.
    if (is_untouched(across)) lock_element(editor_, across);
    const LatticePoint& a = mesh_.at(mesh_.points(t)[next_corner(longest)]);
    const LatticePoint& b = mesh_.at(mesh_.points(t)[previous_corner(longest)]);
    const PointId added = editor_.split_edge(t, longest, {(a.x + b.x) / 2, (a.y + b.y) / 2});
    if (added == kNone) return;
    ++counts_.insertions;
    editor_.legalise(added);
    mesh_.fan_around(added, fan_);
    for (const TriangleId u : fan_) consider(u);
  }

  // Returns true if t is an element from before the cut that lock_element() has not locked yet.
  [[nodiscard]] bool is_untouched(TriangleId t) const {
    if (t == kNone || !mesh_.is_solid(t)) return false;
    const std::array<PointId, 3>& p = mesh_.points(t);
    if (editor_.is_new(p[0]) || editor_.is_new(p[1]) || editor_.is_new(p[2])) return false;
    return (mesh_.locks(t, 0) & mesh_.locks(t, 1) & mesh_.locks(t, 2) & mesh::kLockOriginal) == 0;
  }

  mesh::MeshEditor& editor_;
  const mesh::TriangleMesh& mesh_;
  const PathScale& scale_;
  BisectionConfig config_;
  mesh::RefinementCounts counts_;
  std::deque<Waiting> container_;
  std::vector<TriangleId> fan_;
};

}  // namespace

void lock_elements(mesh::MeshEditor& editor, std::span<const TriangleId> crossed) {
  std::vector<TriangleId> fan;
  for (const TriangleId t : crossed) {
    for (const PointId p : editor.mesh().points(t)) {
      editor.mesh().fan_around(p, fan);
      for (const TriangleId u : fan) {
        if (editor.mesh().is_solid(u)) lock_element(editor, u);
      }
    }
  }
}

Result<mesh::RefinementCounts> bisect_ill_shaped(mesh::MeshEditor& editor, std::span<const TriangleId> seeds,
                                                 const PathScale& scale, const BisectionConfig& config) {
  return Bisection(editor, scale, config).run(seeds);
}

}  // namespace kerf::cut
