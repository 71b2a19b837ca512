#pragma once

#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "server/core/mesh/mesh_data.h"

// Provides exact geometry on the lattice of a mesh, from its records alone.
namespace kerf::audit {

__extension__ using Wide = __int128;

inline std::size_t index(std::int32_t id) {
  return static_cast<std::size_t>(id);
}

inline bool is_solid(const mesh::TriangleRecord& r) {
  return r.region >= 0;
}

// Returns the cross product of a and b: twice the signed area of the triangle of origin, a and b, positive if b is
// counter-clockwise of a.
inline Wide turn(const mesh::LatticePoint& a, const mesh::LatticePoint& b) {
  return Wide{a.x} * b.y - Wide{a.y} * b.x;
}
inline mesh::LatticePoint minus(const mesh::LatticePoint& a, const mesh::LatticePoint& b) {
  return {a.x - b.x, a.y - b.y};
}

// Returns three times the centre of a triangle, which is a lattice point.
inline mesh::LatticePoint tripled_centre(const mesh::MeshData& data, const mesh::TriangleRecord& r) {
  mesh::LatticePoint sum;
  for (const mesh::PointId p : r.points) {
    sum.x += data.points[index(p)].at.x;
    sum.y += data.points[index(p)].at.y;
  }
  return sum;
}

// Converts a point to doubles, in lattice units.
inline Eigen::Vector2d as_vector(const mesh::LatticePoint& p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y)};
}

}  // namespace kerf::audit
