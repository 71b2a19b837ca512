#include "server/core/analysis/lips.h"

#include <algorithm>
#include <limits>

#include <Eigen/Geometry>

namespace kerf::analysis {

namespace {

constexpr double kReach = 1.0e-3;  // -, over the larger side of the bounding box in material coordinates

// Returns true if an edge with this direction runs to the right, or up if it is vertical. Edges of lips have their
// material on the left.
bool goes_right(const Eigen::Vector2d& along) {
  return along.x() != 0.0 ? along.x() > 0.0 : along.y() > 0.0;
}

}  // namespace

std::optional<LipPair> find_lips(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& at) {
  LipPair nearest;
  std::array<double, 2> least{};
  least.fill(kReach * mesh.bounding_box().sizes().maxCoeff());
  std::array<bool, 2> found{};
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      // In the welded mesh there is material beyond a lip, and void beyond the border.
      const mesh::TriangleId across = mesh.welded_neighbour(t, static_cast<int>(k));
      if (mesh.neighbour(t, static_cast<int>(k)) != mesh::kNone || across == mesh::kNone || !mesh.is_solid(across)) {
        continue;
      }
      const auto& corner = mesh.vertices(t);
      LipPoint point{corner[(k + 1) % 3], corner[(k + 2) % 3], corner[k], 0.0};
      const Eigen::Vector2d a = mesh.rest_position(point.a);
      const Eigen::Vector2d along = mesh.rest_position(point.b) - a;
      point.share = std::clamp((at - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
      const double distance = (a + point.share * along - at).norm();
      const std::size_t side = goes_right(along) ? 0 : 1;
      if (!(distance < least[side])) continue;
      least[side] = distance;
      nearest[side] = point;
      found[side] = true;
    }
  }
  if (!found[0] || !found[1]) return std::nullopt;
  return nearest;
}

Eigen::Vector3d opening(const LipPair& lips, const linear::VertexField& x) {
  const auto normal_of = [&](const LipPoint& lip) -> Eigen::Vector3d {
    const Eigen::Vector3d a = x.col(lip.a);
    const Eigen::Vector3d b = x.col(lip.b);
    const Eigen::Vector3d c = x.col(lip.opposite);
    return (b - a).cross(c - a).normalized();
  };
  const Eigen::Vector3d left = (x.col(lips[0].b) - x.col(lips[0].a)).normalized();
  const Eigen::Vector3d right = (x.col(lips[1].a) - x.col(lips[1].b)).normalized();
  const Eigen::Vector3d up = (normal_of(lips[0]) + normal_of(lips[1])).normalized();
  const Eigen::Vector3d mean = left + right;
  const Eigen::Vector3d tangent = (mean - mean.dot(up) * up).normalized();
  const Eigen::Vector3d across = up.cross(tangent);
  const Eigen::Vector3d gap = lips[0].at(x) - lips[1].at(x);
  return {gap.dot(across), gap.dot(tangent), gap.dot(up)};
}

}  // namespace kerf::analysis
