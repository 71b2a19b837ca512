#include "tests/support/intersecting_pairs.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>

namespace kerf::test {
namespace {

using Corners = std::array<Eigen::Vector3d, 3>;

// Returns the sign of the volume of a tetrahedron; 0 if it may be due to rounding.
int orientation(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                const Eigen::Vector3d& d) {
  const Eigen::Vector3d u = a - d, v = b - d, w = c - d;
  const double volume = u.dot(v.cross(w));
  const Eigen::Vector3d p = u.cwiseAbs(), q = v.cwiseAbs(), r = w.cwiseAbs();
  const double terms = p.x() * (q.y() * r.z() + q.z() * r.y()) + p.y() * (q.z() * r.x() + q.x() * r.z()) +
                       p.z() * (q.x() * r.y() + q.y() * r.x());
  if (std::abs(volume) <= 1.0e-15 * terms) return 0;
  return volume > 0.0 ? 1 : -1;
}

bool passes_through(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Corners& of) {
  if (orientation(of[0], of[1], of[2], p) * orientation(of[0], of[1], of[2], q) >= 0) return false;
  const int side = orientation(p, q, of[0], of[1]);
  return side != 0 && orientation(p, q, of[1], of[2]) == side && orientation(p, q, of[2], of[0]) == side;
}

bool intersect(const Corners& a, const Corners& b) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (passes_through(a[k], a[(k + 1) % 3], b) || passes_through(b[k], b[(k + 1) % 3], a)) return true;
  }
  return false;
}

struct Boxed {
  Eigen::AlignedBox3d box;
  Corners corners;
  std::array<mesh::VertexId, 3> vertices;
};

bool share_a_vertex(const Boxed& a, const Boxed& b) {
  return std::find_first_of(a.vertices.begin(), a.vertices.end(), b.vertices.begin(), b.vertices.end()) !=
         a.vertices.end();
}

}  // namespace

std::vector<std::array<mesh::VertexId, 3>> solid_triangles(const mesh::TriangleMesh& mesh) {
  std::vector<std::array<mesh::VertexId, 3>> triangles;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (mesh.is_solid(t)) triangles.push_back(mesh.vertices(t));
  }
  return triangles;
}

std::int64_t count_intersecting_pairs(std::span<const std::array<mesh::VertexId, 3>> triangles,
                                      const linear::VertexField& positions) {
  std::vector<Boxed> boxed;
  boxed.reserve(triangles.size());
  for (const std::array<mesh::VertexId, 3>& vertices : triangles) {
    Boxed& added = boxed.emplace_back();
    added.vertices = vertices;
    for (std::size_t k = 0; k < 3; ++k) {
      added.corners[k] = positions.col(vertices[k]);
      added.box.extend(added.corners[k]);
    }
  }
  std::sort(boxed.begin(), boxed.end(),
            [](const Boxed& a, const Boxed& b) { return a.box.min().x() < b.box.min().x(); });
  std::int64_t count = 0;
  for (std::size_t i = 0; i < boxed.size(); ++i) {
    const Boxed& a = boxed[i];
    for (std::size_t j = i + 1; j < boxed.size() && boxed[j].box.min().x() <= a.box.max().x(); ++j) {
      const Boxed& b = boxed[j];
      if (a.box.intersects(b.box) && !share_a_vertex(a, b) && intersect(a.corners, b.corners)) ++count;
    }
  }
  return count;
}

}  // namespace kerf::test
