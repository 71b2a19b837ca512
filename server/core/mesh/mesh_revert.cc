#include "server/core/mesh/mesh_revert.h"

#include <algorithm>
#include <unordered_map>

#include "server/core/mesh/barycentric.h"
#include "server/core/mesh/mesh_walk.h"

namespace kerf::mesh {
namespace {

// Finds the source of the fields of a vertex that relaxation moved and that the undo moves back to `p`. The source is
// the triangle around `p` in `mesh`, which still has the edit. Relaxation moves no point past a locked edge, so this
// triangle is on the vertex's side of every lip. If rounding put `p` in another piece or the void, the vertex keeps its
// fields.
VertexSource source_at(const TriangleMesh& mesh, VertexId vertex, const LatticePoint& p) {
  struct View {
    const TriangleMesh& mesh;
    [[nodiscard]] const TriangleRecord& triangle(TriangleId t) const { return mesh.record(t); }
    [[nodiscard]] const LatticePoint& at(PointId id) const { return mesh.at(id); }
  };
  const VertexSource itself{vertex, {vertex, vertex, vertex}, {1.0, 0.0, 0.0}};
  const std::int64_t max_steps = 4 * std::int64_t{mesh.num_triangle_slots()} + 100;
  const TriangleId start = mesh.triangle_at(vertex);
  const TriangleId found = walk_to(View{mesh}, p, start, max_steps);
  if (found == kNone || !mesh.is_solid(found) || mesh.piece(found) != mesh.piece(start)) return itself;
  const auto& points = mesh.points(found);
  return {vertex, mesh.vertices(found), barycentric(mesh.at(points[0]), mesh.at(points[1]), mesh.at(points[2]), p)};
}

// Finds the sources of restored vertices. Construct it while the mesh still has the edit.
class Restoration {
 public:
  Restoration(const TriangleMesh& mesh, const CommittedEdit& edit) : restored_(edit.edit.removed_vertices) {
    if (restored_.empty()) return;
    for (const auto& [slot, old] : edit.undo.triangles) {
      for (const VertexId v : old.vertices) {
        if (v != kNone && mesh.has_material(v)) patches_.try_emplace(v, largest_triangle_at(mesh, v));
      }
    }
  }

  // Returns the sources. Proceeds from vertices that kept material to restored neighbours, so each follows material on
  // its own side of every lip. `mesh`: with the edit undone.
  [[nodiscard]] std::vector<VertexSource> place(const TriangleMesh& mesh) const {
    std::unordered_map<VertexId, const Patch*> patch_of;  // looked up, never iterated
    std::vector<VertexId> placed;
    std::vector<TriangleId> ring;
    for (const VertexId v : restored_) {
      mesh.triangles_around(v, ring);
      for (const TriangleId t : ring) {
        for (const VertexId u : mesh.vertices(t)) {
          const auto found = patches_.find(u);
          if (found != patches_.end() && patch_of.emplace(v, &found->second).second) placed.push_back(v);
        }
      }
    }
    for (std::size_t i = 0; i < placed.size(); ++i) {
      mesh.triangles_around(placed[i], ring);
      for (const TriangleId t : ring) {
        for (const VertexId u : mesh.vertices(t)) {
          const bool is_revived = std::binary_search(restored_.begin(), restored_.end(), u);
          if (is_revived && patch_of.emplace(u, patch_of.at(placed[i])).second) placed.push_back(u);
        }
      }
    }
    std::vector<VertexSource> sources;
    sources.reserve(restored_.size());
    for (const VertexId v : restored_) {
      const auto found = patch_of.find(v);
      sources.push_back({v, {v, v, v}, {1.0, 0.0, 0.0}});
      if (found == patch_of.end()) continue;
      const Patch& patch = *found->second;
      sources.back().sources = patch.vertices;
      sources.back().weights = affine(patch.at, mesh.at(mesh.point(v)));
    }
    return sources;
  }

 private:
  struct Patch {
    std::array<VertexId, 3> vertices;
    std::array<LatticePoint, 3> at;
  };

  static Patch largest_triangle_at(const TriangleMesh& mesh, VertexId v) {
    std::vector<TriangleId> ring;
    mesh.triangles_around(v, ring);
    const TriangleId largest = *std::max_element(
        ring.begin(), ring.end(), [&](TriangleId a, TriangleId b) { return mesh.area(a) < mesh.area(b); });
    const auto& p = mesh.points(largest);
    return {mesh.vertices(largest), {mesh.at(p[0]), mesh.at(p[1]), mesh.at(p[2])}};
  }

  // Returns barycentric coordinates, also of points outside.
  static Eigen::Vector3d affine(const std::array<LatticePoint, 3>& at, const LatticePoint& p) {
    const auto whole = static_cast<double>(doubled_area(at[0], at[1], at[2]));
    const double second = static_cast<double>(doubled_area(at[0], p, at[2])) / whole;
    const double third = static_cast<double>(doubled_area(at[0], at[1], p)) / whole;
    return {1.0 - second - third, second, third};
  }

  const std::vector<VertexId>& restored_;
  std::unordered_map<VertexId, Patch> patches_;  // looked up, never iterated
};

}  // namespace

RevertedEdit revert(TriangleMesh& mesh, const CommittedEdit& edit) {
  RevertedEdit reverted;
  reverted.num_vertices = edit.undo.num_vertices;
  reverted.num_slots = edit.undo.num_triangle_slots;
  reverted.removed_vertices = edit.edit.added_vertices;
  std::vector<std::pair<PointId, LatticePoint>> moved_back;  // sorted
  for (const auto& [p, record] : edit.undo.points) {
    if (record.at != mesh.at(p)) moved_back.emplace_back(p, record.at);
  }
  std::sort(moved_back.begin(), moved_back.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const VertexSource& moved : edit.edit.moved_vertices) {
    const auto old = std::lower_bound(moved_back.begin(), moved_back.end(), mesh.point(moved.vertex),
                                      [](const auto& entry, PointId p) { return entry.first < p; });
    if (old == moved_back.end() || old->first != mesh.point(moved.vertex)) continue;
    reverted.moved_vertices.push_back(source_at(mesh, moved.vertex, old->second));
  }
  const auto& rewritten = edit.edit.rewritten_triangles;  // sorted: the new slots are at its end
  reverted.rewritten_triangles.assign(rewritten.begin(),
                                      std::lower_bound(rewritten.begin(), rewritten.end(), reverted.num_slots));
  const Restoration restoration(mesh, edit);
  edit.undo.undo(mesh);
  reverted.restored_vertices = restoration.place(mesh);
  return reverted;
}

}  // namespace kerf::mesh
