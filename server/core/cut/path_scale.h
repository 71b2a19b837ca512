#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "server/core/cut/cut.h"

namespace kerf::cut {

// Bound on rounding of a path to the lattice, with that of points that later split a lip. Each is at most half a unit
// in x and in y, and a lip is halved fewer than 64 times before the length floor.  lattice units
inline constexpr double kRoundingUnits = 64.0;

// Local length scales of a cut. They depend on the edge lengths of the sheet as built, so they are the same for every
// cut of the sheet. Hence a second identical cut meets the lips of the first exactly. All lengths are in m, positions
// in material coordinates. Mesh and options must outlive this.
class PathScale {
 public:
  PathScale(const mesh::TriangleMesh& mesh, const CutOptions& options, double snap);

  // Returns true if all lengths are the same everywhere.
  [[nodiscard]] bool is_uniform() const { return lengths_.is_uniform(); }
  [[nodiscard]] double edge_length(const Eigen::Vector2d& at) const { return lengths_.at(at); }
  // Returns the largest distance allowed between curve and lips.
  [[nodiscard]] double tolerance(const Eigen::Vector2d& at) const { return tolerance_for(lengths_.at(at)); }
  [[nodiscard]] double least_tolerance() const { return tolerance_for(lengths_.least()); }
  [[nodiscard]] double least_tolerance_in(const Eigen::AlignedBox2d& box) const {
    return tolerance_for(lengths_.least_in(box));
  }
  // Returns the least tolerance that can be kept despite rounding to the lattice.
  [[nodiscard]] double representable_tolerance() const;
  // Returns the snap distance: the path is laid on points and lips that are closer.
  [[nodiscard]] double snap(const Eigen::Vector2d& at) const { return snap_for(lengths_.at(at)); }
  // Returns the snap distance at a mesh point, in lattice units.
  [[nodiscard]] double snap_units(const mesh::LatticePoint& at) const {
    return snap(lattice_.position(at)) / lattice_.spacing;
  }
  [[nodiscard]] double mean_snap() const { return snap_for(lengths_.mean); }
  // Return the part of the tolerance that snapping leaves for flattening: the least on the sheet, and the least in a
  // box.
  [[nodiscard]] double least_flattening() const { return flattening_for(lengths_.least()); }
  [[nodiscard]] double least_flattening_in(const Eigen::AlignedBox2d& box) const {
    return flattening_for(lengths_.least_in(box));
  }

  // Divides the segment from a to a + along into the fewest parts that are each at most `fraction` local edge lengths
  // long. Returns the ends of all parts except the last, as fractions of the segment, ascending in (0, 1).
  [[nodiscard]] std::vector<double> divisions(const Eigen::Vector2d& a, const Eigen::Vector2d& along,
                                              double fraction) const;

 private:
  [[nodiscard]] double tolerance_for(double edge_length) const;
  [[nodiscard]] double snap_for(double edge_length) const;
  [[nodiscard]] double flattening_for(double edge_length) const;

  const mesh::EdgeLengths& lengths_;
  const CutOptions& options_;
  double snap_;  // -, CutRequest::snap
  const mesh::Lattice& lattice_;
};

}  // namespace kerf::cut
