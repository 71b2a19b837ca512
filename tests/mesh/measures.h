#pragma once

#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

inline LatticePoint middle_of(const TriangleMesh& mesh, PointId p, PointId q) {
  return {(mesh.at(p).x + mesh.at(q).x) / 2, (mesh.at(p).y + mesh.at(q).y) / 2};
}

// m^2, of the solid triangles.
inline double total_area(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (mesh.is_solid(t)) sum += mesh.area(t);
  }
  return sum;
}

}  // namespace kerf::mesh
