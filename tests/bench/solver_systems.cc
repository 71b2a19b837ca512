#include "tests/bench/solver_systems.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "server/base/check.h"
#include "server/cut/cut.h"
#include "server/fem/integrator.h"
#include "server/fem/membrane.h"
#include "server/fem/vertex_frames.h"
#include "server/mesh/grid_mesh.h"

namespace kerf::bench {
namespace {

constexpr double kFallStep = 1.0 / 60.0;  // s
constexpr int kFallSteps = 30;            // from the horizontal to where the system is taken
constexpr double kSettlingStep = 1.0 / 240.0;

FallenSheet lay_flat(mesh::TriangleMesh mesh, const fem::Material& material, int side) {
  fem::Model model(mesh, material);
  FallenSheet sheet{std::move(mesh), std::move(model), {}, {}};
  fem::State& state = sheet.state;
  state.x = Eigen::Matrix3Xd::Zero(3, sheet.mesh.num_vertices());
  state.v = state.x;
  for (int v = 0; v < sheet.mesh.num_vertices(); ++v) state.x.col(v).head<2>() = sheet.mesh.rest_position(v);
  for (const int v : {side * (side - 1), side * side - 1}) {
    sheet.loads.pins.push_back({v, state.x.col(v), Eigen::Vector3d::Zero()});
  }
  return sheet;
}

void step(FallenSheet& sheet, fem::LinearSolverKind solver, int newton_iterations, int steps, double dt) {
  fem::IntegratorOptions options;
  options.kind = fem::IntegratorKind::kImplicitEuler;
  options.linear_solver = solver;
  options.newton_iterations = newton_iterations;
  const std::unique_ptr<fem::Integrator> integrator = fem::make_integrator(options);
  integrator->rebuild(sheet.model);
  for (int i = 0; i < steps; ++i) integrator->step(sheet.model, sheet.loads, dt, nullptr, sheet.state);
}

// What a grid of side x side vertices on the unit square has at `rest`, linear in its triangles.
Eigen::Vector3d interpolate(const mesh::VertexField& field, int side, const Eigen::Vector2d& rest) {
  const Eigen::Vector2d scaled = rest * (side - 1);
  const int i = std::clamp(static_cast<int>(scaled.x()), 0, side - 2);
  const int j = std::clamp(static_cast<int>(scaled.y()), 0, side - 2);
  const double a = scaled.x() - i;
  const double b = scaled.y() - j;
  const int corner = j * side + i;
  const Eigen::Vector3d across = field.col(corner + side + 1);
  if (a >= b) return (1.0 - a) * field.col(corner) + (a - b) * field.col(corner + 1) + b * across;
  return (1.0 - b) * field.col(corner) + (b - a) * field.col(corner + side) + a * across;
}

}  // namespace

FallenSheet let_fall(const fem::Material& material, int side) {
  FallenSheet sheet = lay_flat(mesh::make_grid({.num_x = side, .num_y = side}).value(), material, side);
  step(sheet, fem::LinearSolverKind::kDirect, 50, kFallSteps, kFallStep);
  return sheet;
}

mesh::TriangleMesh make_sheet(int side, bool slits) {
  mesh::TriangleMesh mesh = mesh::make_grid({.num_x = side, .num_y = side}).value();
  if (!slits) return mesh;
  for (const double y : {0.213, 0.413, 0.613, 0.813}) {
    const Result<cut::CutPlan> plan = cut::plan(mesh, {cut::Polyline{{{0.2, y}, {0.8, y + 0.01}}}, {}, {}});
    KERF_CHECK(plan.ok(), "slits are within the sheet");
    KERF_CHECK(cut::apply(mesh, *plan).ok(), "slits are within the sheet");
  }
  return mesh;
}

FallenSheet refine(const FallenSheet& fallen, const fem::Material& material, mesh::TriangleMesh mesh, int side) {
  FallenSheet sheet = lay_flat(std::move(mesh), material, side);
  for (int v = 0; v < sheet.mesh.num_vertices(); ++v) {
    sheet.state.x.col(v) = interpolate(fallen.state.x, kMostFallen, sheet.mesh.rest_position(v));
    sheet.state.v.col(v) = interpolate(fallen.state.v, kMostFallen, sheet.mesh.rest_position(v));
  }
  step(sheet, fem::LinearSolverKind::kFactorCg, 5, 1, kSettlingStep);
  return sheet;
}

System linearise(const FallenSheet& sheet, double dt) {
  const fem::Model& model = sheet.model;
  const fem::State& state = sheet.state;
  const int num_vertices = sheet.mesh.num_vertices();
  System system;
  const fem::MaterialScale scale{dt * dt, dt, {}};
  system.tangent.rebuild(model);
  system.tangent.set_mass(model, 1.0);
  system.tangent.add_membrane(model, state.x, {}, scale, dt * dt, true);
  system.tangent.add_bending(model, scale);
  mesh::VertexField force = Eigen::Matrix3Xd::Zero(3, num_vertices);
  mesh::VertexField scratch(num_vertices);
  fem::add_membrane_forces(model.element_blocks(), model.materials(), {}, state.x, state.v, force);
  model.add_bending_forces(state.x, state.v, {}, scratch, force);
  system.b.resize(num_vertices);
  for (int v = 0; v < num_vertices; ++v) {
    const double m = model.mass()[static_cast<std::size_t>(v)];
    system.b.col(v) = m * (dt * state.v.col(v) + dt * dt * sheet.loads.gravity) + dt * dt * force.col(v);
  }
  system.exact = Eigen::Matrix3Xd::Zero(3, num_vertices);
  system.tangent.constrain(model, sheet.loads.pins, 0.0, state.x, system.b, system.exact);
  system.frames.resize(static_cast<std::size_t>(num_vertices));
  fem::find_vertex_frames(model.element_blocks(), state.x, system.frames);
  system.positions = state.x;
  return system;
}

}  // namespace kerf::bench
