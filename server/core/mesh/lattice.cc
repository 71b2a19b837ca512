#include "server/core/mesh/lattice.h"

#include <cmath>

#include "server/base/check.h"

namespace kerf::mesh {

Lattice Lattice::for_bounds(const Eigen::AlignedBox2d& bounds) {
  const double side = bounds.sizes().maxCoeff();
  KERF_CHECK(std::isfinite(side) && side > 0.0, "a sheet has a positive, finite size");
  int exponent = 0;
  const double fraction = std::frexp(side, &exponent);  // side = fraction * 2^exponent, fraction in [0.5, 1)
  if (fraction == 0.5) --exponent;
  const double size = std::ldexp(1.0, exponent);
  const Eigen::Vector2d centre = bounds.center();
  Lattice lattice;
  lattice.origin = {size * std::nearbyint(centre.x() / size), size * std::nearbyint(centre.y() / size)};
  lattice.spacing = std::ldexp(size, -51);
  return lattice;
}

bool Lattice::contains(const Eigen::Vector2d& position) const {
  const double limit = static_cast<double>(kHalfDomain - 1) * spacing;
  return std::abs(position.x() - origin.x()) < limit && std::abs(position.y() - origin.y()) < limit;
}

LatticePoint Lattice::nearest(const Eigen::Vector2d& position) const {
  KERF_DCHECK(contains(position), "only positions in the domain have a lattice point");
  return {std::llrint((position.x() - origin.x()) / spacing), std::llrint((position.y() - origin.y()) / spacing)};
}

}  // namespace kerf::mesh
