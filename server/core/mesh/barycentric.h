#pragma once

#include <Eigen/Core>

#include "server/core/mesh/lattice.h"
#include "server/core/mesh/predicates.h"

namespace kerf::mesh {

// Returns the barycentric coordinates of p in triangle (a, b, c), from exact areas. Negative ones become 0, and the sum
// is scaled to 1.
inline Eigen::Vector3d barycentric(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c,
                                   const LatticePoint& p) {
  const auto share = [](Int128 area) { return area > 0 ? to_double(area) : 0.0; };
  const Eigen::Vector3d areas(share(doubled_area(b, c, p)), share(doubled_area(c, a, p)), share(doubled_area(a, b, p)));
  return areas / (areas.x() + areas.y() + areas.z());
}

}  // namespace kerf::mesh
