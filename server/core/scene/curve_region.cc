#include "server/core/scene/curve_region.h"

#include <algorithm>
#include <limits>

#include "server/core/cut/curve.h"

namespace kerf::scene {

namespace {

constexpr double kRegionFlatness = 0.01;  // -; distance of the chords from the curve, over its reach
constexpr double kNoLength = std::numeric_limits<double>::min();
constexpr double kTie = 1.0e-9;  // -; chords whose distances differ relatively by less may meet at a joint

std::vector<mesh::SizeSource> chords_of(const MaterialCurve& curve, const mesh::TriangleMesh& mesh) {
  const double reach = curve.within > 0.0 ? curve.within : kCurveTolerance * mesh.edge_lengths().least();
  const double finest = kRegionTolerance * mesh.bounding_box().sizes().maxCoeff();
  std::vector<mesh::SizeSource> chords;
  for (const cut::Stroke& stroke : cut::flatten(curve.curve, std::max(kRegionFlatness * reach, finest)).strokes) {
    for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
      chords.push_back({stroke.points[i], stroke.points[i + 1], kNoLength, 1.0});
    }
  }
  return chords;
}

Eigen::Vector2d nearest_on(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& at) {
  const Eigen::Vector2d along = b - a;
  return a + std::clamp(along.dot(at - a) / along.squaredNorm(), 0.0, 1.0) * along;
}

}  // namespace

CurveRegion::CurveRegion(const MaterialCurve& curve, const mesh::TriangleMesh& mesh)
    : mesh_(mesh),
      within_(curve.within),
      chords_(chords_of(curve, mesh)),
      distance_(std::numeric_limits<double>::max(), chords_) {}

bool CurveRegion::reaches(const Eigen::Vector2d& at) const {
  const double reach = within_ > 0.0 ? within_ : kCurveTolerance * mesh_.edge_lengths().at(at);
  return distance_.at(at) <= reach;
}

CurveRegion::Nearest CurveRegion::nearest(const Eigen::Vector2d& at) const {
  Nearest found;
  double least = std::numeric_limits<double>::max();
  for (const mesh::SizeSource& chord : chords_) {
    const Eigen::Vector2d point = nearest_on(chord.a, chord.b, at);
    const double distance = (point - at).norm();
    if (distance > (1.0 + kTie) * least) continue;
    const Eigen::Vector2d along = (chord.b - chord.a).normalized();
    const Eigen::Vector2d left(-along.y(), along.x());
    const bool is_joint =
        distance >= (1.0 - kTie) * least && (point - found.point).norm() <= kTie * (chord.b - chord.a).norm();
    found.left = is_joint ? Eigen::Vector2d(found.left + left) : left;
    found.point = point;
    least = std::min(least, distance);
  }
  return found;
}

Eigen::Vector2d CurveRegion::left_at(const Eigen::Vector2d& at) const {
  return nearest(at).left;
}

double CurveRegion::offset(const Eigen::Vector2d& at) const {
  const Nearest found = nearest(at);
  return found.left.dot(at - found.point);
}

std::vector<mesh::VertexId> border_vertices(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& point,
                                            const ComponentPlace* component) {
  mesh::TriangleId start = mesh::kNone;
  double least = std::numeric_limits<double>::infinity();
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    for (int k = 0; k < 3; ++k) {
      const mesh::TriangleId across = mesh.welded_neighbour(t, k);
      if (across == mesh::kNone || mesh.is_solid(across)) continue;
      const auto& corner = mesh.points(t);
      const Eigen::Vector2d a = mesh.point_position(corner[static_cast<std::size_t>((k + 1) % 3)]);
      const Eigen::Vector2d b = mesh.point_position(corner[static_cast<std::size_t>((k + 2) % 3)]);
      if (component != nullptr && !component->room.contains(a)) continue;
      const double distance = (nearest_on(a, b, point) - point).squaredNorm();
      if (!(distance < least)) continue;
      least = distance;
      start = across;
    }
  }
  std::vector<mesh::VertexId> found;
  if (start == mesh::kNone) return found;
  std::vector<bool> seen(static_cast<std::size_t>(mesh.num_triangle_slots()), false);
  std::vector<mesh::TriangleId> waiting{start};
  seen[static_cast<std::size_t>(start)] = true;
  while (!waiting.empty()) {
    const mesh::TriangleId slot = waiting.back();
    waiting.pop_back();
    for (int k = 0; k < 3; ++k) {
      const mesh::TriangleId across = mesh.welded_neighbour(slot, k);
      if (across == mesh::kNone) continue;
      if (!mesh.is_solid(across)) {
        if (!seen[static_cast<std::size_t>(across)]) waiting.push_back(across);
        seen[static_cast<std::size_t>(across)] = true;
        continue;
      }
      const int mirror = mesh.mirror_corner(slot, k);
      for (const int end : {1, 2}) found.push_back(mesh.vertices(across)[static_cast<std::size_t>((mirror + end) % 3)]);
    }
  }
  return found;
}

}  // namespace kerf::scene
