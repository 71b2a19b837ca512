#include "tests/bench/solver_system.h"

#include <memory>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/membrane.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/element/vertex_frames.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/step/integrator.h"

namespace kerf::bench {

System system_at(const fem::Model& model, const fem::Loads& loads, const fem::State& state, double step) {
  const int num_vertices = model.num_vertices();
  System system;
  const fem::MaterialScale scale{step * step, step, {}};
  system.tangent.rebuild(model);
  system.tangent.set_mass(model, 1.0);
  system.tangent.add_membrane(model, state.x, {}, scale, step * step, true);
  system.tangent.add_bending(model, scale);
  linear::VertexField force = Eigen::Matrix3Xd::Zero(3, num_vertices);
  linear::VertexField scratch(num_vertices);
  fem::add_membrane_forces(model.element_blocks(), model.materials(), {}, state.x, state.v, force);
  model.bending().add_forces(model.element_blocks(), state.x, state.v, {}, scratch, force);
  system.b.resize(num_vertices);
  for (int v = 0; v < num_vertices; ++v) {
    const double m = model.mass()[static_cast<std::size_t>(v)];
    system.b.col(v) = m * (step * state.v.col(v) + step * step * loads.gravity) + step * step * force.col(v);
  }
  system.exact = Eigen::Matrix3Xd::Zero(3, num_vertices);
  system.tangent.constrain(model, loads.pins, 0.0, state.x, system.b, system.exact);
  system.frames.resize(static_cast<std::size_t>(num_vertices));
  fem::find_vertex_frames(model.element_blocks(), state.x, system.frames);
  system.positions = state.x;
  return system;
}

fem::Loads corners_pinned(const mesh::TriangleMesh& mesh, int side) {
  fem::Loads loads;
  for (const int v : {side * (side - 1), side * side - 1}) {
    const Eigen::Vector2d at = mesh.rest_position(v);
    loads.pins.push_back({v, {at.x(), at.y(), 0.0}, Eigen::Vector3d::Zero()});
  }
  return loads;
}

fem::State flat(const mesh::TriangleMesh& mesh) {
  fem::State state;
  state.x = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  state.v = state.x;
  for (int v = 0; v < mesh.num_vertices(); ++v) state.x.col(v).head<2>() = mesh.rest_position(v);
  return state;
}

void fall(const fem::Model& model, const fem::Loads& loads, double step, int steps, fem::State& state) {
  fem::IntegratorOptions options;
  options.kind = fem::IntegratorKind::kImplicitEuler;
  options.linear_solver = linear::LinearSolverKind::kDirect;
  options.newton_iterations = 50;
  const std::unique_ptr<fem::Integrator> integrator = fem::make_integrator(options);
  integrator->rebuild(model);
  for (int i = 0; i < steps; ++i) integrator->step(model, loads, step, nullptr, state);
}

}  // namespace kerf::bench
