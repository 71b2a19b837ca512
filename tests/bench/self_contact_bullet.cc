#include "tests/bench/self_contact_bullet.h"

#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "tests/bench/bullet_sheet.h"

namespace kerf::bench {
namespace {

constexpr int kClusters = 64;

// Links along edges, and between vertices two edges apart for bending. Clusters of vertices collide with each other as
// convex bodies.
class CollidingSoftBody : public Contender {
 public:
  CollidingSoftBody(const sheet::Sheet& sheet, int substeps, int iterations, bool collides_with_itself)
      : substeps_(substeps) {
    world_.setGravity(to_bullet(sheet.gravity()));
    world_.getWorldInfo().m_gravity = to_bullet(sheet.gravity());
    floor_shape_.setMargin(0);
    floor_.setFriction(1);  // friction of a pair is the product of both
    world_.addRigidBody(&floor_);
    body_ = make_bullet_sheet(world_.getWorldInfo(), sheet.mesh(), sheet.state().x, sheet.model().mass());
    body_->m_materials[0]->m_kLST = 1;
    body_->generateBendingConstraints(2);
    body_->m_cfg.piterations = iterations;
    body_->m_cfg.kDF = static_cast<btScalar>(sheet.config().colliders.front().friction);
    body_->getCollisionShape()->setMargin(static_cast<btScalar>(0.5 * sheet.config().material.thickness));
    body_->generateClusters(kClusters);
    body_->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::CL_SS;
    if (collides_with_itself) body_->m_cfg.collisions |= btSoftBody::fCollision::CL_SELF;
    world_.addSoftBody(body_);
  }
  void tick() override {
    for (int i = 0; i < substeps_; ++i) world_.stepSimulation(static_cast<btScalar>(kTick / substeps_), 0);
  }
  [[nodiscard]] Eigen::Matrix3Xd positions() const override { return bullet_positions(*body_); }
  ~CollidingSoftBody() override {
    world_.removeSoftBody(body_);
    delete body_;
    world_.removeRigidBody(&floor_);
  }

 private:
  int substeps_;
  BulletSurroundings around_;
  btSequentialImpulseConstraintSolver contacts_;
  btSoftRigidDynamicsWorld world_{&around_.dispatcher, &around_.broadphase, &contacts_, &around_.configuration};
  btStaticPlaneShape floor_shape_{btVector3(0, 0, 1), 0};
  btRigidBody floor_{btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &floor_shape_)};
  btSoftBody* body_ = nullptr;
};

SelfContactEntry soft_body(int substeps, bool collides_with_itself) {
  constexpr int kIterations = 20;
  return {"Bullet, " + std::to_string(substeps) + " x " + std::to_string(kIterations) + " iterations, " +
              std::to_string(kClusters) + " clusters" + (collides_with_itself ? ", CL_SELF" : ""),
          [=](const sheet::Sheet& sheet) {
            return std::make_unique<CollidingSoftBody>(sheet, substeps, kIterations, collides_with_itself);
          }};
}

}  // namespace

std::vector<SelfContactEntry> bullet_self_contact_entries() {
  return {soft_body(1, true), soft_body(1, false), soft_body(4, true)};
}

}  // namespace kerf::bench
