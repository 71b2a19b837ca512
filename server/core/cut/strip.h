#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "server/base/result.h"
#include "server/core/cut/curve.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::cut {

// The mesh edges that an outline runs along. For each edge it holds the winding number of the outline on the left less
// that on the right. It follows splits of edges.
class OutlineEdges {
 public:
  // Records that the outline runs along edge pq, from p to q.
  void add(mesh::PointId p, mesh::PointId q) { change(p, q, 1); }
  // Replaces edge pq by its halves after a split at m. Does nothing if pq is not on the outline.
  void split(mesh::PointId p, mesh::PointId q, mesh::PointId m);
  // Returns the winding number on the left of pq, seen from p, less that on its right. 0 if the outline does not run
  // along pq, or runs equally often in both directions.
  [[nodiscard]] std::int32_t step(mesh::PointId p, mesh::PointId q) const;
  struct Edge {
    mesh::PointId from, to;  // with the strip on the left: step(from, to) > 0
  };
  // Returns the edges with a step other than 0, sorted by their lower end, then the higher one.
  [[nodiscard]] std::vector<Edge> edges() const;

 private:
  void change(mesh::PointId p, mesh::PointId q, std::int32_t step);
  std::unordered_map<std::uint64_t, std::int32_t> steps_;  // step() from the lower to the higher end, by both ends
};

// Returns the solid triangles inside an outline that was put into the mesh, ascending. Older lips may lie inside.
// `outline`: the whole outline, also beyond the sheet; it decides on pieces that do not touch `outline_edges`.
// `room`: box outside of which nothing is removed, m; absent: none. `max_area_m2`: upper bound of the strip's area,
// m^2. Errors: kFailedPrecondition CUT_NOT_REPRESENTABLE (the strip's sides could not be distinguished: shift the
// curve), and
//         STRIP_COVERS_SHEET (nothing would be left).
Result<std::vector<mesh::TriangleId>> strip_triangles(const mesh::TriangleMesh& mesh, const OutlineEdges& outline_edges,
                                                      const std::vector<Stroke>& outline,
                                                      const std::optional<Box>& room, double max_area_m2);

}  // namespace kerf::cut
