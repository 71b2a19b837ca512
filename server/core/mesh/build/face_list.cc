#include "server/core/mesh/build/face_list.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Geometry>

#include "server/base/sort_unique.h"

namespace kerf::mesh {
namespace {

constexpr double kFlatness = 1e-6;  // -; distance from a plane that still counts as flat, over the size of the sheet;
                                    // single-precision files round by 1e-7

Status too_many(std::size_t limit, const std::string& what) {
  return invalid_argument("TOO_LARGE", "more than " + std::to_string(limit) + " " + what);
}

// Returns the sum of the triangles' area vectors. Components need not have one orientation, so a vector that points
// against the sum so far is turned round.
Eigen::Vector3d total_area(const ImportedSheet& imported) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Eigen::Index t = 0; t < imported.sheet.triangles.cols(); ++t) {
    const Eigen::Vector3d a = imported.world.col(imported.sheet.triangles(0, t));
    const Eigen::Vector3d b = imported.world.col(imported.sheet.triangles(1, t));
    const Eigen::Vector3d c = imported.world.col(imported.sheet.triangles(2, t));
    const Eigen::Vector3d area = (b - a).cross(c - a);
    sum += sum.dot(area) < 0.0 ? Eigen::Vector3d(-area) : area;
  }
  return sum;
}

}  // namespace

Status FaceList::add_position(const Eigen::Vector3d& position) {
  if (!position.allFinite()) return invalid_argument("NUMBER", "a position is three finite numbers");
  if (position.cwiseAbs().maxCoeff() > kMaxRestCoordinate) {
    return invalid_argument("NUMBER", "a position is at most 1e4 m from the origin in each coordinate");
  }
  constexpr auto kMost = static_cast<std::size_t>(kMaxVertices);
  if (positions_.size() == kMost) return too_many(kMost, "positions");
  positions_.push_back(position);
  return Nothing{};
}

Status FaceList::add_texture(const Eigen::Vector2d& texture) {
  if (!texture.allFinite()) return invalid_argument("NUMBER", "a texture coordinate is one or two finite numbers");
  constexpr std::size_t kMost = 4 * static_cast<std::size_t>(kMaxVertices);
  if (textures_.size() == kMost) return too_many(kMost, "texture coordinates");
  textures_.push_back(texture);
  return Nothing{};
}

Status FaceList::add_face(std::span<const Corner> corners) {
  if (corners.size() < 3) return invalid_argument("FACE", "a face has at least 3 corners");
  if (corners.size() > kMaxFaceCorners) {
    return invalid_argument("FACE", "more than " + std::to_string(kMaxFaceCorners) + " corners");
  }
  if (triangles_.empty()) has_texture_ = corners.front().second != kNone;
  for (const Corner& corner : corners) {
    if ((corner.second != kNone) != has_texture_) {
      return invalid_argument("MIXED_TEXTURE", "some face corners have a texture coordinate and others do not");
    }
  }
  constexpr std::size_t kMost = 2 * static_cast<std::size_t>(kMaxVertices);
  if (triangles_.size() + corners.size() - 2 > kMost) return too_many(kMost, "triangles");
  for (std::size_t i = 2; i < corners.size(); ++i) triangles_.push_back({corners[0], corners[i - 1], corners[i]});
  return Nothing{};
}

// Numbers the different corners as vertices, by position and then by texture coordinate.
Result<ImportedSheet> FaceList::assemble(RestShape rest_shape) const {
  if (triangles_.empty()) return invalid_argument("EMPTY", "no face");
  std::vector<Corner> vertices;
  vertices.reserve(3 * triangles_.size());
  for (const std::array<Corner, 3>& triangle : triangles_) {
    vertices.insert(vertices.end(), triangle.begin(), triangle.end());
  }
  sort_unique(vertices);
  const auto num_vertices = static_cast<Eigen::Index>(vertices.size());
  ImportedSheet imported;
  imported.world.resize(3, num_vertices);
  for (Eigen::Index v = 0; v < num_vertices; ++v) {
    imported.file_positions.push_back(vertices[v].first);
    imported.world.col(v) = positions_[vertices[v].first];
  }
  imported.sheet.triangles.resize(3, static_cast<Eigen::Index>(triangles_.size()));
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const auto at = std::lower_bound(vertices.begin(), vertices.end(), triangles_[t][k]);
      imported.sheet.triangles(k, static_cast<Eigen::Index>(t)) = static_cast<std::int32_t>(at - vertices.begin());
    }
  }
  if (has_texture_) {
    imported.sheet.rest.resize(2, num_vertices);
    for (Eigen::Index v = 0; v < num_vertices; ++v) imported.sheet.rest.col(v) = textures_[vertices[v].second];
    if (rest_shape == RestShape::kSurface) imported.sheet.surface = imported.world;
    return imported;
  }
  const Status flat = flatten(imported);
  if (flat.ok()) return imported;
  if (rest_shape == RestShape::kFlat) return flat.error();
  imported.sheet.surface = imported.world;
  return imported;
}

// Computes the material coordinates of a planar sheet.
Status FaceList::flatten(ImportedSheet& imported) const {
  const Eigen::Vector3d origin = imported.world.col(0);
  const Eigen::Vector3d area = total_area(imported);
  const Eigen::Vector3d extent = imported.world.rowwise().maxCoeff() - imported.world.rowwise().minCoeff();
  const double size = extent.maxCoeff();
  if (!(area.norm() > kFlatness * size * size)) {
    return invalid_argument("NOT_PLANAR",
                            "the faces do not lie in one plane; give them texture coordinates as rest shape, or use "
                            "the curved surface itself");
  }
  const Eigen::Vector3d normal = area.normalized();
  for (Eigen::Index v = 0; v < imported.world.cols(); ++v) {
    const double height = std::abs(normal.dot(imported.world.col(v) - origin));
    if (height > kFlatness * size) {
      return invalid_argument(
          "NOT_PLANAR", "position " + std::to_string(imported.file_positions[v] + first_number_) + " is " +
                            std::to_string(height) + " m out of the plane of the first one, the limit is " +
                            std::to_string(kFlatness * size) +
                            " m; give the faces texture coordinates as rest shape, or use the curved surface itself");
    }
  }
  imported.sheet.rest.resize(2, imported.world.cols());
  if (std::abs(normal.z()) > 1.0 - kFlatness) {
    imported.sheet.rest = imported.world.topRows<2>();
    return Nothing{};
  }
  // The material x axis is the projection into the plane of the world axis that is least along the normal.
  Eigen::Index axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  const Eigen::Vector3d u = (Eigen::Vector3d::Unit(axis) - normal[axis] * normal).normalized();
  const Eigen::Vector3d v = normal.cross(u);
  for (Eigen::Index i = 0; i < imported.world.cols(); ++i) {
    const Eigen::Vector3d offset = imported.world.col(i) - origin;
    imported.sheet.rest.col(i) = Eigen::Vector2d(u.dot(offset), v.dot(offset));
  }
  return Nothing{};
}

}  // namespace kerf::mesh
