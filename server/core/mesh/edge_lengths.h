#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace kerf::mesh {

struct TriangleRecord;
struct PointRecord;
struct Lattice;

// Local edge lengths of a sheet as built, on a grid of cells over its bounding box. A cell's length is the mean of
// sqrt(2 area) over the triangles near it. It is rounded to the mean over the whole sheet times a power of two. So a
// sheet of nearly equal triangles has one length everywhere. Cuts do not change it.
struct EdgeLengths {
  Eigen::AlignedBox2d bounds;          // m
  double mean = 0.0;                   // m, > 0; mean of sqrt(2 area) over all triangles of the sheet
  std::int32_t columns = 0, rows = 0;  // number of cells in x and y; 0 if one length holds everywhere
  std::vector<std::int8_t> exponents;  // rows x columns, row by row from the lower left: length = mean * 2^exponent
  std::int8_t least_exponent = 0;      // least of `exponents`; 0 if there are none

  // Measures the triangles of a mesh as built; `bounds` is the sheet's bounding box.
  static EdgeLengths of(std::span<const TriangleRecord> triangles, std::span<const PointRecord> points,
                        const Lattice& lattice, const Eigen::AlignedBox2d& bounds);

  [[nodiscard]] bool is_uniform() const { return exponents.empty(); }
  // Returns the length at a place, m. Outside the bounding box it is that of the nearest cell.
  [[nodiscard]] double at(const Eigen::Vector2d& position) const;
  // Returns the least length of all cells, m.
  [[nodiscard]] double least() const;
  // Returns the least length of all cells that a box (m) overlaps or touches, m.
  [[nodiscard]] double least_in(const Eigen::AlignedBox2d& box) const;
  // Returns the shorter side of a cell, m; infinity if one length holds everywhere.
  [[nodiscard]] double resolution() const;

  friend bool operator==(const EdgeLengths& a, const EdgeLengths& b);
};

}  // namespace kerf::mesh
