#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "server/base/result.h"
#include "server/core/cut/curve.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::cut {

// The edges of the mesh that an outline was laid on, and by how much its winding number is larger on the left of each:
// kept up to date as edges are split.
class OutlineEdges {
 public:
  // Adds edge pq, which the outline runs along from p to q.
  void add(mesh::PointId p, mesh::PointId q) { change(p, q, 1); }
  // Replaces edge pq, on the outline or not, by its halves after a split at m.
  void split(mesh::PointId p, mesh::PointId q, mesh::PointId m);
  // Returns the winding number on the left of pq, seen from p, less that on its right. 0 if the outline does not run
  // along pq, or runs equally often in both directions.
  [[nodiscard]] std::int32_t step(mesh::PointId p, mesh::PointId q) const;
  struct Edge {
    mesh::PointId from, to;  // with the strip on the left: step(from, to) > 0
  };
  // Ascending by the lower end, then the higher one.
  [[nodiscard]] std::vector<Edge> edges() const;

 private:
  void change(mesh::PointId p, mesh::PointId q, std::int32_t step);
  std::unordered_map<std::uint64_t, std::int32_t> steps_;  // by both ends, the lower one first; seen from that
};

// Returns the solid triangles of the strip surrounded by an outline laid into the mesh, in ascending order. Older lips
// may lie inside.
// `outline`: the whole of it, beyond the sheet too, for pieces that lie inside without touching it. `max_area_m2`:
// upper bound of the strip's area, m^2.
// Errors: kFailedPrecondition CUT_NOT_REPRESENTABLE (its sides could not be distinguished: shift the curve), and
//         STRIP_COVERS_SHEET, where nothing would be left.
Result<std::vector<mesh::TriangleId>> strip_triangles(const mesh::TriangleMesh& mesh, const OutlineEdges& outline_edges,
                                                      const std::vector<Stroke>& outline, double max_area_m2);

}  // namespace kerf::cut
