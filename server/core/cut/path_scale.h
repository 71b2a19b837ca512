#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "server/core/cut/cut.h"

namespace kerf::cut {

// Rounding of a path to the lattice, and of the points that later split a lip: each at most half a unit in x and in y,
// and a lip is halved fewer than 64 times before the length floor.  lattice units
inline constexpr double kRoundingUnits = 64.0;

// Local length scales of a cut: fractions of the edge length of the sheet as built. So they are the same for every cut
// on it, and a second identical cut meets the lips of the first exactly. All in m; positions in material coordinates.
// Refers to the mesh and the options.
class PathScale {
 public:
  PathScale(const mesh::TriangleMesh& mesh, const CutOptions& options, double snap);

  // Returns true if all lengths are the same everywhere.
  [[nodiscard]] bool is_uniform() const { return lengths_.is_uniform(); }
  [[nodiscard]] double edge_length(const Eigen::Vector2d& at) const { return lengths_.at(at); }
  // Largest distance allowed between curve and lips.
  [[nodiscard]] double tolerance(const Eigen::Vector2d& at) const { return tolerance_for(lengths_.at(at)); }
  [[nodiscard]] double least_tolerance() const { return tolerance_for(lengths_.least()); }
  [[nodiscard]] double least_tolerance_in(const Eigen::AlignedBox2d& box) const {
    return tolerance_for(lengths_.least_in(box));
  }
  // Least tolerance that the lattice can keep.
  [[nodiscard]] double representable_tolerance() const;
  // Distance below which the path is laid on points and lips.
  [[nodiscard]] double snap(const Eigen::Vector2d& at) const { return snap_for(lengths_.at(at)); }
  // Snap distance at a point of the mesh, in lattice units.
  [[nodiscard]] double snap_units(const mesh::LatticePoint& at) const {
    return snap(lattice_.position(at)) / lattice_.spacing;
  }
  [[nodiscard]] double mean_snap() const { return snap_for(lengths_.mean); }
  // Return the part of the tolerance that snapping leaves for flattening: the least anywhere, and in a box.
  [[nodiscard]] double least_flattening() const { return flattening_for(lengths_.least()); }
  [[nodiscard]] double least_flattening_in(const Eigen::AlignedBox2d& box) const {
    return flattening_for(lengths_.least_in(box));
  }

  // Divides the segment from a to a + along into the fewest parts no longer than `fraction` edge lengths there. Returns
  // the ends of all parts except the last, as fractions of the segment, ascending in (0, 1).
  [[nodiscard]] std::vector<double> divisions(const Eigen::Vector2d& a, const Eigen::Vector2d& along,
                                              double fraction) const;

 private:
  [[nodiscard]] double tolerance_for(double edge_length) const;
  [[nodiscard]] double snap_for(double edge_length) const;
  [[nodiscard]] double flattening_for(double edge_length) const;

  const mesh::EdgeLengths& lengths_;
  const CutOptions& options_;
  double snap_;  // -, see CutRequest
  const mesh::Lattice& lattice_;
};

}  // namespace kerf::cut
