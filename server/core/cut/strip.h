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
class LaidOutline {
 public:
  // The outline runs along edge pq, from p to q.
  void run(mesh::PointId p, mesh::PointId q) { add(p, q, 1); }
  // Edge pq, on the outline or not, was split at m.
  void split(mesh::PointId p, mesh::PointId q, mesh::PointId m);
  // Winding number on the left of pq, seen from p, less that on its right. 0 where the outline does not run, or as
  // often there as back.
  [[nodiscard]] std::int32_t step(mesh::PointId p, mesh::PointId q) const;
  struct Edge {
    mesh::PointId from, to;  // with the strip on the left: step(from, to) > 0
  };
  // Ascending by the lower end, then the higher one.
  [[nodiscard]] std::vector<Edge> edges() const;

 private:
  void add(mesh::PointId p, mesh::PointId q, std::int32_t step);
  std::unordered_map<std::uint64_t, std::int32_t> steps_;  // by both ends, the lower one first; seen from that
};

// The solid triangles of the strip that an outline laid into the mesh surrounds, older lips inside it or not, in
// ascending order.
// `outline`: the whole of it, beyond the sheet too, for pieces that lie inside without touching it. `max_area_m2`: what
// the strip cannot exceed.
// Errors: kFailedPrecondition CUT_NOT_REPRESENTABLE (its sides could not be distinguished: shift the curve), and
//         STRIP_COVERS_SHEET, where nothing would be left.
Result<std::vector<mesh::TriangleId>> strip_triangles(const mesh::TriangleMesh& mesh, const LaidOutline& laid,
                                                      const std::vector<Stroke>& outline, double max_area_m2);

}  // namespace kerf::cut
