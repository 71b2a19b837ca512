// Interpolation sources of new and moved vertices: weights in the mesh before the edit, read through the undo log.

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/base/check.h"
#include "server/base/sort_unique.h"
#include "server/core/mesh/barycentric.h"
#include "server/core/mesh/mesh_editor.h"
#include "server/core/mesh/mesh_walk.h"

namespace kerf::mesh {

// Returns the solid slot of the mesh before the edit that holds p, or the solid slot beside it if p was rounded out of
// the sheet.
TriangleId MeshEditor::locate_in_old(const LatticePoint& p, TriangleId start) const {
  struct OldMesh {
    const MeshEditor& editor;
    [[nodiscard]] const TriangleRecord& triangle(TriangleId t) const { return editor.old_record(t); }
    [[nodiscard]] const LatticePoint& at(PointId id) const { return editor.old_at(id); }
  };
  const OldMesh view{*this};
  const TriangleId found = walk_to(view, p, start, 4 * static_cast<std::int64_t>(log_.num_triangle_slots) + 100);
  if (found == kNone) return start;
  const TriangleRecord& record = old_record(found);
  if (record.region != kNone) return found;
  TriangleId nearest = start;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const TriangleId n = record.neighbours[k];
    if (n == kNone || old_record(n).region == kNone) continue;
    const LatticePoint& a = old_at(record.points[next_corner(k)]);
    const LatticePoint& b = old_at(record.points[previous_corner(k)]);
    const double distance =
        static_cast<double>(doubled_area(a, b, p)) / std::sqrt(static_cast<double>(dot(a, b, a, b)));
    if (distance < least) {
      least = distance;
      nearest = n;
    }
  }
  return nearest;
}

// Interpolates at a vertex that is not on an edge locked before the edit, so had material all around. The walk starts
// from the slot of the point, not of the vertex. So all vertices at a point get the same sources, and new lips are
// equal bit for bit.
VertexSource MeshEditor::interpolate(VertexId v) const {
  const PointRecord& point = mesh_.data().points[mesh_.point(v)];
  const LatticePoint& p = point.at;
  const TriangleRecord& record = old_record(locate_in_old(p, parent_of(point.triangle)));
  return {v, record.vertices,
          barycentric(old_at(record.points[0]), old_at(record.points[1]), old_at(record.points[2]), p)};
}

VertexSource MeshEditor::interpolate_on_lip(VertexId v, const Lip& lip) const {
  const TriangleRecord& record = old_record(lip.triangle);
  const int ka = next_corner(lip.corner), kb = previous_corner(lip.corner);
  const LatticePoint& a = old_at(record.points[ka]);
  const LatticePoint& b = old_at(record.points[kb]);
  const LatticePoint& p = mesh_.at(mesh_.point(v));
  const double share =
      std::clamp(static_cast<double>(dot(a, b, a, p)) / static_cast<double>(dot(a, b, a, b)), 0.0, 1.0);
  VertexSource source{v, {kNone, kNone, kNone}, Eigen::Vector3d::Zero()};
  source.sources = record.vertices;
  source.weights[ka] = 1.0 - share;
  source.weights[kb] = share;
  return source;
}

VertexSource MeshEditor::source_of(const NewVertex& added) const {
  if (added.lip.triangle != kNone) return interpolate_on_lip(added.vertex, added.lip);
  if (added.origin == kNone || is_moved(mesh_.point(added.vertex))) return interpolate(added.vertex);
  return {added.vertex, {added.origin, added.origin, added.origin}, {1.0, 0.0, 0.0}};
}

std::vector<VertexSource> MeshEditor::moved_sources() const {
  std::vector<VertexId> moved;
  std::vector<TriangleId> fan;
  for (const PointId p : moved_) {
    if (!is_moved(p)) continue;
    mesh_.fan_around(p, fan);
    for (const TriangleId t : fan) {
      const VertexId v = mesh_.vertices(t)[mesh_.corner_of(t, p)];
      const bool is_listed = !moved.empty() && moved.back() == v;
      if (v != kNone && v < log_.num_vertices && !is_listed) moved.push_back(v);
    }
  }
  sort_unique(moved);
  std::vector<VertexSource> sources;
  sources.reserve(moved.size());
  for (const VertexId v : moved) sources.push_back(interpolate(v));
  return sources;
}

// Returns new slots, old slots whose content changed, and slots around moved points, whose rest shape changed. A change
// of the piece number alone does not count.
std::vector<TriangleId> MeshEditor::rewritten_triangles() const {
  std::vector<TriangleId> rewritten;
  for (const auto& [t, old] : log_.triangles) {
    const TriangleRecord& now = mesh_.record(t);
    const bool is_solid = now.region != kNone;
    bool differs = now.region != old.region || now.vertices != old.vertices || (is_solid && now.points != old.points);
    for (int k = 0; k < 3 && is_solid && !differs; ++k) {
      const TriangleId before = (old.locks[k] & kLocksThatOpen) != 0 ? kNone : old.neighbours[k];
      differs = mesh_.neighbour(t, k) != before;
    }
    if (differs) rewritten.push_back(t);
  }
  IdMap listed;
  for (const TriangleId t : rewritten) listed.add(t);
  std::vector<TriangleId> fan;
  for (const PointId p : moved_) {
    if (!is_moved(p)) continue;
    mesh_.fan_around(p, fan);
    for (const TriangleId t : fan) {
      if (t < log_.num_triangle_slots && mesh_.is_solid(t) && listed.add(t)) rewritten.push_back(t);
    }
  }
  std::sort(rewritten.begin(), rewritten.end());
  for (TriangleId t = log_.num_triangle_slots; t < mesh_.num_triangle_slots(); ++t) rewritten.push_back(t);
  return rewritten;
}

}  // namespace kerf::mesh
