#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include "tests/bench/bullet_sheet.h"
#include "tests/bench/race_bullet.h"

namespace kerf::bench {
namespace {

btSoftBody* make_sheet(btSoftBodyWorldInfo& world, const Scene& scene) {
  btSoftBody* sheet = make_bullet_sheet(world, scene.mesh, scene.state.x, scene.model.mass());
  for (const fem::Pin& pin : scene.loads.pins) sheet->setMass(pin.vertex, 0);
  return sheet;
}

// btSoftBody in a btSoftRigidDynamicsWorld: links projected one after the other, `iterations` times a substep.
class BulletSoftBody : public Contender {
 public:
  BulletSoftBody(const Scene& scene, int substeps, int iterations) : substeps_(substeps) {
    world_.setGravity(to_bullet(scene.loads.gravity));
    world_.getWorldInfo().m_gravity = to_bullet(scene.loads.gravity);
    sheet_ = make_sheet(world_.getWorldInfo(), scene);
    sheet_->m_materials[0]->m_kLST = 1;
    sheet_->m_cfg.piterations = iterations;
    sheet_->m_cfg.kDP = static_cast<btScalar>(1.0 - std::exp(-scene.air_drag * kTick / substeps));
    world_.addSoftBody(sheet_);
  }
  void tick() override {
    for (int i = 0; i < substeps_; ++i) world_.stepSimulation(static_cast<btScalar>(kTick / substeps_), 0);
  }
  [[nodiscard]] Eigen::Matrix3Xd positions() const override { return bullet_positions(*sheet_); }
  ~BulletSoftBody() override {
    world_.removeSoftBody(sheet_);
    delete sheet_;
  }

 private:
  int substeps_;
  BulletSurroundings around_;
  btSequentialImpulseConstraintSolver contacts_;
  btSoftRigidDynamicsWorld world_{&around_.dispatcher, &around_.broadphase, &contacts_, &around_.configuration};
  btSoftBody* sheet_ = nullptr;
};

// N/m, of a spring along each edge of a grid: as the network may shear sideways where it hangs, springs along the load
// alone hold it, and this gives it the sheet's stretch at rest.
constexpr double kSpring = 1000.0 / (1.0 - 0.3 * 0.3);

// One Newton step without line search, Bullet's default, or more with; nothing public sets their number.
class NewtonSolver : public btDeformableBodySolver {
 public:
  explicit NewtonSolver(int iterations) { m_maxNewtonIterations = iterations; }
};

// btSoftBody in a btDeformableMultiBodyDynamicsWorld: implicit Euler on springs.
class BulletDeformable : public Contender {
 public:
  BulletDeformable(const Scene& scene, int substeps, int newton_iterations)
      : substeps_(substeps),
        drag_(static_cast<btScalar>(std::exp(-scene.air_drag * kTick / substeps))),
        solver_(newton_iterations),
        gravity_(to_bullet(scene.loads.gravity)) {
    world_.setGravity(to_bullet(scene.loads.gravity));
    world_.getWorldInfo().m_gravity = to_bullet(scene.loads.gravity);
    contacts_.setDeformableSolver(&solver_);
    world_.setUseProjection(true);  // its other way of holding pins leaves the whole sheet where it is
    world_.setImplicit(true);
    world_.setLineSearch(newton_iterations > 1);
    sheet_ = make_sheet(world_.getWorldInfo(), scene);
    world_.addSoftBody(sheet_);
    world_.addForce(sheet_, &springs_);
    world_.addForce(sheet_, &gravity_);
  }
  void tick() override {
    for (int i = 0; i < substeps_; ++i) {
      world_.stepSimulation(static_cast<btScalar>(kTick / substeps_), 0);
      for (int v = 0; v < sheet_->m_nodes.size(); ++v) sheet_->m_nodes[v].m_v *= drag_;
    }
  }
  [[nodiscard]] Eigen::Matrix3Xd positions() const override { return bullet_positions(*sheet_); }
  ~BulletDeformable() override {
    world_.removeSoftBody(sheet_);
    delete sheet_;
  }

 private:
  int substeps_;
  btScalar drag_;
  BulletSurroundings around_;
  NewtonSolver solver_;
  btDeformableMultiBodyConstraintSolver contacts_;
  btDeformableMassSpringForce springs_{static_cast<btScalar>(kSpring), 0};
  btDeformableGravityForce gravity_;
  btDeformableMultiBodyDynamicsWorld world_{&around_.dispatcher, &around_.broadphase, &contacts_,
                                            &around_.configuration, &solver_};
  btSoftBody* sheet_ = nullptr;
};

Entry soft_body(int substeps, int iterations) {
  return {"Bullet soft body", std::to_string(substeps) + " x " + std::to_string(iterations) + " iterations",
          [=](const Scene& scene) { return std::make_unique<BulletSoftBody>(scene, substeps, iterations); }};
}

Entry deformable(int substeps, int newton_iterations) {
  return {"Bullet deformable", std::to_string(substeps) + " x " + std::to_string(newton_iterations) + " Newton",
          [=](const Scene& scene) { return std::make_unique<BulletDeformable>(scene, substeps, newton_iterations); }};
}

}  // namespace

std::vector<Entry> bullet_entries() {
  return {soft_body(1, 1),  soft_body(1, 10),  soft_body(1, 50), soft_body(1, 200), soft_body(4, 50), soft_body(4, 200),
          soft_body(50, 1), soft_body(120, 1), deformable(1, 1), deformable(4, 1),  deformable(1, 5), deformable(4, 5)};
}

}  // namespace kerf::bench
