#include "tests/bench/bullet_sheet.h"

#include <cstddef>
#include <vector>

#include <BulletSoftBody/btSoftBodyHelpers.h>

namespace kerf::bench {

btVector3 to_bullet(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

btSoftBody* make_bullet_sheet(btSoftBodyWorldInfo& world, const mesh::TriangleMesh& mesh,
                              const linear::VertexField& positions, std::span<const double> masses) {
  std::vector<btScalar> vertices;
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    for (int axis = 0; axis < 3; ++axis) vertices.push_back(static_cast<btScalar>(positions(axis, v)));
  }
  std::vector<int> corners;
  for (int t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    const auto& of = mesh.vertices(t);
    corners.insert(corners.end(), of.begin(), of.end());
  }
  btSoftBody* sheet = btSoftBodyHelpers::CreateFromTriMesh(world, vertices.data(), corners.data(),
                                                           static_cast<int>(corners.size() / 3));
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    sheet->setMass(v, static_cast<btScalar>(masses[static_cast<std::size_t>(v)]));
  }
  sheet->m_cfg.collisions = 0;
  sheet->setActivationState(DISABLE_DEACTIVATION);
  return sheet;
}

Eigen::Matrix3Xd bullet_positions(const btSoftBody& sheet) {
  Eigen::Matrix3Xd x(3, sheet.m_nodes.size());
  for (int v = 0; v < sheet.m_nodes.size(); ++v) {
    const btVector3& at = sheet.m_nodes[v].m_x;
    x.col(v) = Eigen::Vector3d(at.x(), at.y(), at.z());
  }
  return x;
}

}  // namespace kerf::bench
