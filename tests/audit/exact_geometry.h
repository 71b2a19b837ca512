#pragma once

#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "server/core/mesh/mesh_data.h"

// Exact geometry on the lattice of a mesh, found from its records alone.
namespace kerf::audit {

__extension__ using Wide = __int128;

inline std::size_t index(std::int32_t id) {
  return static_cast<std::size_t>(id);
}

inline bool is_solid(const mesh::TriangleRecord& r) {
  return r.region >= 0;
}

// The turn from a to b around the origin: twice the area of the triangle that they make with it.
inline Wide turn(const mesh::LatticePoint& a, const mesh::LatticePoint& b) {
  return Wide{a.x} * b.y - Wide{a.y} * b.x;
}
inline mesh::LatticePoint minus(const mesh::LatticePoint& a, const mesh::LatticePoint& b) {
  return {a.x - b.x, a.y - b.y};
}

// Three times the centre of a triangle.
inline mesh::LatticePoint tripled_centre(const mesh::MeshData& data, const mesh::TriangleRecord& r) {
  mesh::LatticePoint sum;
  for (const mesh::PointId p : r.points) {
    sum.x += data.points[index(p)].at.x;
    sum.y += data.points[index(p)].at.y;
  }
  return sum;
}

// Lattice units, rounded.
inline Eigen::Vector2d as_vector(const mesh::LatticePoint& p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y)};
}

}  // namespace kerf::audit
