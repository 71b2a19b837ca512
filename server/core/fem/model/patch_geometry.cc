#include "server/core/fem/model/patch_geometry.h"

#include <Eigen/Geometry>

#include "server/core/fem/model/border_clamps.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::fem {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

// Returns the surface point `at` turned about the edge into the plane, to the right of the edge. The plane edge is
// `edge`, with the triangle on its left.
Eigen::Vector2d unfolded(const std::array<Eigen::Vector2d, 2>& edge, const std::array<Eigen::Vector3d, 2>& surface,
                         const Eigen::Vector3d& at) {
  const Eigen::Vector3d along = (surface[1] - surface[0]).normalized();
  const Eigen::Vector3d offset = at - surface[0];
  const double distance = along.dot(offset);
  const double height = (offset - distance * along).norm();
  const Eigen::Vector2d direction = (edge[1] - edge[0]).normalized();
  return edge[0] + distance * direction + height * Eigen::Vector2d(direction.y(), -direction.x());
}

}  // namespace

std::size_t corner_across(const mesh::TriangleMesh& mesh, TriangleId slot, TriangleId from) {
  const std::array<TriangleId, 3>& neighbours = mesh.record(slot).neighbours;
  return (neighbours[1] == from ? 1U : 0U) + (neighbours[2] == from ? 2U : 0U);
}

std::array<VertexId, 6> patch_vertices(const RestSheet& sheet, TriangleId slot) {
  const mesh::TriangleMesh& mesh = sheet.mesh;
  std::array<VertexId, 6> made;
  made.fill(mesh::kNone);
  if (!sheet.elements.has_material(slot)) return made;
  const std::array<VertexId, 3> vertices = sheet.elements.corners(slot);
  for (std::size_t k = 0; k < 3; ++k) {
    made[k] = vertices[k];
    const TriangleId across = mesh.neighbour(slot, static_cast<int>(k));
    if (across != mesh::kNone) made[3 + k] = mesh.vertices(across)[corner_across(mesh, across, slot)];
  }
  return made;
}

PatchGeometry flat_patch(const RestSheet& sheet, const BorderClamps& clamps, TriangleId slot) {
  const std::array<VertexId, 6> vertex = patch_vertices(sheet, slot);
  const Eigen::Matrix2d& axes = sheet.elements.law(slot).axes;
  PatchGeometry patch;
  for (std::size_t k = 0; k < 3; ++k) {
    patch.corners[k] = axes * sheet.mesh.rest_position(vertex[k]);
    patch.opposite[k].setZero();
    if (vertex[3 + k] != mesh::kNone) {
      patch.opposite[k] = axes * sheet.mesh.rest_position(vertex[3 + k]);
      patch.edges[k] = PatchEdge::kNeighbour;
      continue;
    }
    if (clamps.gradient_at(sheet, slot, k)) patch.edges[k] = PatchEdge::kClamped;
  }
  return patch;
}

PatchGeometry curved_patch(const RestSheet& sheet, TriangleId slot, PatchSurface& surface) {
  const mesh::TriangleMesh& mesh = sheet.mesh;
  const mesh::Facet* const facet = mesh.facet(slot);
  const Eigen::Matrix2d edges = sheet.elements.law(slot).axes * mesh.rest_edges(slot);
  PatchGeometry patch{{Eigen::Vector2d::Zero(), edges.col(0), edges.col(1)}, {}, {}};
  const std::array<Eigen::Vector2d, 3>& X = patch.corners;
  std::array<Eigen::Vector3d, 6>& at = surface.at;
  surface.is_bent = false;
  const std::array<VertexId, 6> vertex = patch_vertices(sheet, slot);
  for (std::size_t k = 0; k < 3; ++k) at[k] = facet->at(mesh.rest_position(vertex[k]));
  for (std::size_t k = 0; k < 3; ++k) {
    patch.opposite[k].setZero();
    at[3 + k] = at[0];
    const TriangleId across = mesh.neighbour(slot, static_cast<int>(k));
    if (across == mesh::kNone) continue;
    patch.edges[k] = PatchEdge::kNeighbour;
    surface.is_bent = surface.is_bent || mesh.facet(across) != facet;
    at[3 + k] = mesh.facet(across)->at(mesh.rest_position(vertex[3 + k]));
    patch.opposite[k] = unfolded({X[(k + 1) % 3], X[(k + 2) % 3]}, {at[(k + 1) % 3], at[(k + 2) % 3]}, at[3 + k]);
  }
  return patch;
}

}  // namespace kerf::fem
