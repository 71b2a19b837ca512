#include "server/mesh/mesh_revert.h"

#include <algorithm>

#include "server/mesh/barycentric.h"
#include "server/mesh/mesh_walk.h"

namespace kerf::mesh {
namespace {

// Where the fields at `p` are read from in the mesh with the edit in it. Only a point that no locked edge ends at is
// ever moved, and no lock lies in the polygon that it is moved in: the slot that holds `p` is on its side of every lip.
// Where rounding put it elsewhere the vertex keeps its fields.
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
  edit.undo.undo(mesh);
  return reverted;
}

}  // namespace kerf::mesh
