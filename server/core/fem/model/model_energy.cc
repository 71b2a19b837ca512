#include <Eigen/Geometry>

#include "server/core/fem/element/angle_bending.h"
#include "server/core/fem/element/bending_forces.h"
#include "server/core/fem/element/membrane.h"
#include "server/core/fem/model/model.h"

namespace kerf::fem {

double Model::total_mass() const {
  double total = 0.0;
  for (const double m : mass_) total += m;
  return total;
}

double Model::rest_area() const {
  double total = 0.0;
  for (const ElementBlock& block : blocks_) {
    for (const double area : block.area) total += area;
  }
  return total;
}

double Model::typical_edge_length() const {
  constexpr double kShare = 0.1;  // of the vertices
  std::int64_t total = 0;
  for (const auto& [length, count] : num_vertices_by_edge_length_) total += count;
  for (const auto& [length, count] : num_vertices_by_edge_length_) {
    if (static_cast<double>(count) >= kShare * static_cast<double>(total)) return length;
  }
  return 0.0;
}

void Model::internal_forces(const mesh::VertexField& x, mesh::VertexField& f) const {
  f.setZero();
  add_membrane_forces(blocks_, materials_, {}, x, x, f);
  if (angle_bending_ != nullptr) return angle_bending_->add_forces(x, f);
  fem::add_bending_forces(bending_rows_, x, f);
  add_clamp_forces(clamp_forces_, f);
  add_rest_bending_forces(rest_bending(), x, x, {}, f);
}

void Model::add_bending_forces(const mesh::VertexField& x, const mesh::VertexField& v, std::span<const double> beta,
                               mesh::VertexField& damped, mesh::VertexField& f) const {
  if (!has_bending()) return;
  if (angle_bending_ != nullptr) {
    add_bending_damping(bending_terms(), beta, v, f);
    angle_bending_->add_forces(x, f);
    return;
  }
  if (is_uniform(beta)) {
    damped = x + damping_of(beta, 0) * v;
    fem::add_bending_forces(bending_rows_, damped, f);
  } else {
    fem::add_bending_forces(bending_rows_, x, f);
    add_bending_damping(bending_terms(), beta, v, f);
  }
  add_clamp_forces(clamp_forces_, f);
  add_rest_bending_forces(rest_bending(), x, v, beta, f);
}

double Model::bending_energy(const mesh::VertexField& x) const {
  if (angle_bending_ != nullptr) return angle_bending_->energy(x);
  return fem::bending_energy(bending_rows_, x) + clamp_energy(clamp_forces_, x) +
         rest_bending_energy(rest_bending(), x);
}

Energies Model::energies(const State& state, const Eigen::Vector3d& gravity) const {
  Energies energies;
  energies.membrane = membrane_energy(blocks_, materials_, state.x);
  energies.bending = bending_energy(state.x);
  for (int i = 0; i < num_vertices(); ++i) {
    const double m = mass_[static_cast<std::size_t>(i)];
    energies.gravity -= m * gravity.dot(state.x.col(i));
    energies.kinetic += 0.5 * m * state.v.col(i).squaredNorm();
  }
  return energies;
}

Momentum Model::momentum(const State& state) const {
  Momentum momentum;
  for (int i = 0; i < num_vertices(); ++i) {
    const Eigen::Vector3d p = mass_[static_cast<std::size_t>(i)] * state.v.col(i);
    momentum.linear += p;
    momentum.angular += state.x.col(i).cross(p);
  }
  return momentum;
}

Eigen::Vector3d Model::centre_of_mass(const mesh::VertexField& x) const {
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (int i = 0; i < num_vertices(); ++i) moment += mass_[static_cast<std::size_t>(i)] * x.col(i);
  return moment / total_mass();
}

}  // namespace kerf::fem
