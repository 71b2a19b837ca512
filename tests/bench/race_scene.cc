#include "tests/bench/race_scene.h"

#include <utility>

#include "server/base/check.h"
#include "server/core/cut/cut.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "tests/support/cut_patterns.h"

namespace kerf::bench {
namespace {

fem::Material damped(fem::Material material, double mass_damping) {
  material.mass_damping = mass_damping;
  return material;
}

class Own : public Contender {
 public:
  Own(const Scene& scene, const fem::IntegratorOptions& options)
      : scene_(scene), integrator_(fem::make_integrator(options)) {
    integrator_->rebuild(scene_.model);
  }
  void tick() override { integrator_->step(scene_.model, scene_.loads, kTick, nullptr, scene_.state); }
  [[nodiscard]] Eigen::Matrix3Xd positions() const override { return scene_.state.x; }

 private:
  Scene scene_;
  std::unique_ptr<fem::Integrator> integrator_;
};

}  // namespace

fem::Material cloth() {
  return fem::isotropic(2.0e6, 0.3, 5.0e-4, 400.0);
}

mesh::TriangleMesh grid(int side) {
  return mesh::make_grid({.num_x = side, .num_y = side}).value();
}

mesh::TriangleMesh cut_grid(int side) {
  mesh::TriangleMesh mesh = grid(side);
  for (const cut::Curve& curve : test::kirigami(5, 4)) {
    const Result<cut::CutPlan> plan = cut::plan(mesh, {curve, {}, {}});
    KERF_CHECK(plan.ok() && cut::apply(mesh, *plan).ok(), "the benchmark's cut is refused");
  }
  return mesh;
}

Scene::Scene(mesh::TriangleMesh sheet, double drag, bool hangs, fem::MembraneLaw law, const fem::Material& material)
    : mesh(std::move(sheet)), air_drag(drag), model(mesh, damped(material, drag), law) {
  state.x = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  state.v = state.x;
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    const Eigen::Vector2d at = mesh.rest_position(v);
    state.x.col(v) = hangs ? Eigen::Vector3d(at.x(), 0.0, at.y()) : Eigen::Vector3d(at.x(), at.y(), 0.0);
    if (at.y() > 1.0 - 1e-9) loads.pins.push_back({v, state.x.col(v), Eigen::Vector3d::Zero()});
  }
}

fem::IntegratorOptions explicit_options(fem::Precision precision) {
  fem::IntegratorOptions options;
  options.kind = fem::IntegratorKind::kExplicit;
  options.precision = precision;
  return options;
}

fem::IntegratorOptions reference_options() {
  fem::IntegratorOptions options = explicit_options(fem::Precision::kDouble);
  options.cfl = 0.1;
  options.highest_mode_damping = 0.0;
  options.max_substeps = 1'000'000;
  return options;
}

fem::IntegratorOptions implicit_options(fem::IntegratorKind kind, int newton_iterations,
                                        linear::LinearSolverKind solver) {
  fem::IntegratorOptions options;
  options.kind = kind;
  options.newton_iterations = newton_iterations;
  options.linear_solver = solver;
  options.max_linear_iterations = 10'000;
  return options;
}

std::unique_ptr<Contender> make_own(const Scene& scene, const fem::IntegratorOptions& options) {
  return std::make_unique<Own>(scene, options);
}

}  // namespace kerf::bench
