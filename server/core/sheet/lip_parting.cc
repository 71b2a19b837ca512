#include "server/core/sheet/lip_parting.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "server/base/sort_unique.h"

namespace kerf::sheet {
namespace {

using mesh::VertexId;

// Returns the way of a vertex into its material, m.
Eigen::Vector3d way_inward(const mesh::TriangleMesh& mesh, VertexId v, double thickness,
                           const Eigen::Ref<Eigen::Matrix3Xd>& x, std::vector<mesh::TriangleId>& ring) {
  constexpr double kShare = 0.03;           // -, of the thickness
  constexpr double kShareOfAltitude = 0.1;  // -, most, of the least altitude at the vertex
  Eigen::Vector3d inward = Eigen::Vector3d::Zero();
  double altitude = std::numeric_limits<double>::infinity();
  mesh.triangles_around(v, ring);
  for (const mesh::TriangleId t : ring) {
    const std::array<VertexId, 3>& corners = mesh.vertices(t);
    const auto at = static_cast<std::size_t>(std::find(corners.begin(), corners.end(), v) - corners.begin());
    const Eigen::Vector3d first = (x.col(corners[(at + 1) % 3]) - x.col(v)).normalized();
    const Eigen::Vector3d second = (x.col(corners[(at + 2) % 3]) - x.col(v)).normalized();
    // The integral of unit vectors over the angle at v, so that ways are perpendicular to straight lips.
    inward += (first - second).norm() * (first + second).normalized();
    double longest = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      longest = std::max(longest, (mesh.rest_position(corners[c]) - mesh.rest_position(corners[(c + 1) % 3])).norm());
    }
    altitude = std::min(altitude, 2.0 * mesh.material_area(t) / longest);
  }
  const double length = inward.norm();
  if (!(length > 0.0)) return Eigen::Vector3d::Zero();
  return std::min(kShare * thickness, kShareOfAltitude * altitude) / length * inward;
}

}  // namespace

void part_lips(const mesh::TriangleMesh& mesh, std::span<const mesh::TriangleId> triangles,
               std::span<const VertexId> held, double thickness, Eigen::Ref<Eigen::Matrix3Xd> x) {
  std::vector<std::pair<mesh::PointId, VertexId>> copies;
  for (const mesh::TriangleId t : triangles) {
    if (!mesh.is_solid(t)) continue;
    for (const VertexId v : mesh.vertices(t)) copies.emplace_back(mesh.point(v), v);
  }
  sort_unique(copies);
  std::vector<std::pair<VertexId, Eigen::Vector3d>> ways;
  std::vector<mesh::TriangleId> ring;
  for (auto begin = copies.begin(); begin != copies.end();) {
    const auto end = std::find_if(begin, copies.end(), [&](const auto& copy) { return copy.first != begin->first; });
    for (auto it = begin; it != end; ++it) {
      const VertexId v = it->second;
      const bool lies_on_another =
          std::any_of(begin, end, [&](const auto& copy) { return copy.second != v && x.col(copy.second) == x.col(v); });
      if (!lies_on_another || std::binary_search(held.begin(), held.end(), v)) continue;
      ways.emplace_back(v, way_inward(mesh, v, thickness, x, ring));
    }
    begin = end;
  }
  for (const auto& [v, way] : ways) x.col(v) += way;
}

}  // namespace kerf::sheet
