#pragma once

#include <span>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <Eigen/Core>

#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/triangle_mesh.h"

// Sheets of Kerf in Bullet's terms.
namespace kerf::bench {

btVector3 to_bullet(const Eigen::Vector3d& v);

// Returns a soft body with the triangles of a mesh at `positions` (3 x V, m) and with `masses` (kg, length V). Each
// edge is a link, at rest as it is. The body collides with nothing. The caller deletes it.
btSoftBody* make_bullet_sheet(btSoftBodyWorldInfo& world, const mesh::TriangleMesh& mesh,
                              const linear::VertexField& positions, std::span<const double> masses);

// 3 x V, m.
Eigen::Matrix3Xd bullet_positions(const btSoftBody& sheet);

// Holds the objects that every Bullet world needs.
struct BulletSurroundings {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
};

}  // namespace kerf::bench
