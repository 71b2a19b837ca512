#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "server/core/mesh/predicates.h"

namespace kerf::mesh {

// The fixed-point lattice that rest space is quantised to, once, when a mesh is built: position = origin + spacing *
// (x, y). Let S be the least power of two that is no less than either side of the sheet's bounding box. Then spacing =
// S * 2^-51, and origin = the box's centre rounded to a multiple of S (so 0 for most sheets near the origin). Hence the
// sheet lies within |x|, |y| <= 2^51, and the domain, where points may be inserted, reaches to 2^52: at least S of room
// on every side. Rounding moves a position by at most S * 2^-52, about one unit in the last place of a double of size
// S.
struct Lattice {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  // m
  double spacing = 1.0;                              // m, > 0, a power of two

  // For a sheet with this bounding box (m), finite, with a positive side.
  static Lattice for_bounds(const Eigen::AlignedBox2d& bounds);

  // Half the side of the square domain around lattice (0, 0) that the void fills, lattice units.
  static constexpr std::int64_t kHalfDomain = kMaxCoordinate;

  // m. Exact while |origin| <= 2 S, else rounded to nearest.
  [[nodiscard]] Eigen::Vector2d position(const LatticePoint& point) const {
    return {origin.x() + spacing * static_cast<double>(point.x), origin.y() + spacing * static_cast<double>(point.y)};
  }

  // Returns true if position (m, finite) lies strictly inside the domain.
  [[nodiscard]] bool contains(const Eigen::Vector2d& position) const;

  // Nearest lattice point; position (m) must lie in the domain.
  [[nodiscard]] LatticePoint nearest(const Eigen::Vector2d& position) const;

  // S, the least room on every side of the sheet, m.
  [[nodiscard]] double room() const { return 0.5 * static_cast<double>(kHalfDomain) * spacing; }

  friend bool operator==(const Lattice& a, const Lattice& b) { return a.origin == b.origin && a.spacing == b.spacing; }
};

}  // namespace kerf::mesh
