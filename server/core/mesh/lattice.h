#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "server/core/mesh/predicates.h"

namespace kerf::mesh {

// The lattice that material coordinates are rounded to, once, when a mesh is built: position = origin + spacing * (x,
// y) with integers x, y. Let S be the least power of two that is no less than either side of the sheet's bounding box.
// Then spacing = S * 2^-51, and origin is the box's centre rounded to a multiple of S, so mostly 0. Hence the sheet
// lies within |x|, |y| <= 2^51. The domain, the square in which points may be inserted, reaches to 2^52, so at least S
// beyond the sheet on every side. Rounding moves a position by at most S * 2^-52, about one unit in the last place of a
// double of size S.
struct Lattice {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  // m
  double spacing = 1.0;                              // m, > 0, a power of two

  // Makes the lattice of a sheet with this bounding box (m), which is finite and has a positive side.
  static Lattice for_bounds(const Eigen::AlignedBox2d& bounds);

  // Half the side of the domain, a square around lattice point (0, 0), lattice units.
  static constexpr std::int64_t kHalfDomain = kMaxCoordinate;

  // Returns the material coordinates of a lattice point, m. Exact if |origin| <= 2 S, else rounded to nearest.
  [[nodiscard]] Eigen::Vector2d position(const LatticePoint& point) const {
    return {origin.x() + spacing * static_cast<double>(point.x), origin.y() + spacing * static_cast<double>(point.y)};
  }

  // Returns true if position (m, finite) lies strictly inside the domain.
  [[nodiscard]] bool contains(const Eigen::Vector2d& position) const;

  // Returns the nearest lattice point. `position` (m) must lie in the domain.
  [[nodiscard]] LatticePoint nearest(const Eigen::Vector2d& position) const;

  // S: least distance from the sheet to the edge of the domain, m.
  [[nodiscard]] double room() const { return 0.5 * static_cast<double>(kHalfDomain) * spacing; }

  friend bool operator==(const Lattice& a, const Lattice& b) { return a.origin == b.origin && a.spacing == b.spacing; }
};

}  // namespace kerf::mesh
