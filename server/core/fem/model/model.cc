#include "server/core/fem/model/model.h"

#include <Eigen/Geometry>

#include "server/base/state_hash.h"
#include "server/core/fem/element/membrane.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::fem {

using mesh::TriangleId;
using mesh::VertexId;

Model::Model(const mesh::TriangleMesh& mesh, const Material& material, MembraneLaw law)
    : Model(mesh, std::span<const Material>(&material, 1), law) {}

Model::Model(const mesh::TriangleMesh& mesh, std::span<const Material> materials, MembraneLaw law)
    : elements_(materials, law) {
  std::vector<TriangleId> everything(static_cast<std::size_t>(mesh.num_triangle_slots()));
  for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) everything[static_cast<std::size_t>(t)] = t;
  // Reserves a quarter more for large arrays, so that the first cuts need not move them.
  masses_.reserve(static_cast<std::size_t>(mesh.num_vertices()) * 5 / 4);
  const std::size_t slots = everything.size() * 5 / 4;
  elements_.reserve(slots);
  if (elements_.materials().has_bending()) bending_.reserve(slots);
  follow(mesh, everything);
  elements_.make_room();
  bending_.make_room();
}

MassChange Model::apply(const mesh::TriangleMesh& mesh, const mesh::MeshEdit& edit) {
  return follow(mesh, edit.rewritten_triangles);
}

MassChange Model::follow(const mesh::TriangleMesh& mesh, const std::vector<TriangleId>& rewritten,
                         PhaseObserver* observer) {
  enter_phase(observer, "elements");
  elements_.follow(mesh, rewritten);
  const RestSheet sheet{mesh, elements_};
  enter_phase(observer, "masses");
  MassChange change = masses_.follow(sheet);
  enter_phase(observer, "bending");
  bending_.follow(sheet, rewritten);
  enter_phase(observer, "stability bound");
  stiffness_bound_.update(stiffness_problem(mesh), elements_.touched().members(), change.vertices,
                          bending_.changed_rows());
  return change;
}

void Model::set_clamps(const mesh::TriangleMesh& mesh, std::vector<Clamp> clamps) {
  if (!bending_.set_clamps({mesh, elements_}, BorderClamps(std::move(clamps)))) return;
  stiffness_bound_.update(stiffness_problem(mesh), {}, {}, bending_.changed_rows());
}

StiffnessProblem Model::stiffness_problem(const mesh::TriangleMesh& mesh) const {
  return {element_blocks(), elements_.incident_slots(), bending_.bound_rows(), materials(), inverse_mass(),
          mesh.is_curved()};
}

std::span<const VertexId> Model::changed_rows() const {
  return materials().has_bending() ? bending_.changed_rows() : elements_.touched().members();
}

void Model::internal_forces(const linear::VertexField& x, linear::VertexField& f) const {
  f.setZero();
  add_membrane_forces(element_blocks(), materials(), {}, x, x, f);
  bending_.add_forces(element_blocks(), x, f);
}

Energies Model::energies(const State& state, const Eigen::Vector3d& gravity) const {
  Energies energies;
  energies.membrane = membrane_energy(element_blocks(), materials(), state.x);
  energies.bending = bending_.energy(element_blocks(), state.x);
  for (int i = 0; i < num_vertices(); ++i) {
    const double m = mass()[static_cast<std::size_t>(i)];
    energies.gravity -= m * gravity.dot(state.x.col(i));
    energies.kinetic += 0.5 * m * state.v.col(i).squaredNorm();
  }
  return energies;
}

Momentum Model::momentum(const State& state) const {
  Momentum momentum;
  for (int i = 0; i < num_vertices(); ++i) {
    const Eigen::Vector3d p = mass()[static_cast<std::size_t>(i)] * state.v.col(i);
    momentum.linear += p;
    momentum.angular += state.x.col(i).cross(p);
  }
  return momentum;
}

Eigen::Vector3d Model::centre_of_mass(const linear::VertexField& x) const {
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (int i = 0; i < num_vertices(); ++i) moment += mass()[static_cast<std::size_t>(i)] * x.col(i);
  return moment / masses_.total();
}

std::uint64_t Model::hash() const {
  StateHash hash;
  elements_.add_to(hash);
  masses_.add_to(hash);
  bending_.add_to(hash);
  hash.add(stiffness_bound_.value());
  return hash.value();
}

}  // namespace kerf::fem
