#pragma once

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "server/base/random.h"
#include "server/core/fem/model/model.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "server/core/mesh/build/mesh_import.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::fem {

// n x n vertices on a square of `size` m.
inline mesh::TriangleMesh square_grid(int n, double size = 1.0) {
  return mesh::make_grid({.num_x = n, .num_y = n, .width = size, .height = size}).value();
}

inline mesh::TriangleMesh jittered_square(int n, double size = 1.0, std::uint64_t seed = 1) {
  return mesh::make_jittered_grid({.num_x = n, .num_y = n, .width = size, .height = size}, seed).value();
}

// On the curved rest shape, at rest.
inline State rest_on_surface(const mesh::TriangleMesh& mesh) {
  State state;
  state.x = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  state.v = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    if (mesh.has_material(v)) state.x.col(v) = mesh.facet(mesh.triangle_at(v))->at(mesh.rest_position(v));
  }
  return state;
}

// Flat in the plane z = 0, at rest.
inline State rest_state(const mesh::TriangleMesh& mesh) {
  State state;
  state.x = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  state.v = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  for (int i = 0; i < mesh.num_vertices(); ++i) state.x.col(i).head<2>() = mesh.rest_position(i);
  return state;
}

// Along all border edges, N m/m.
inline std::vector<EdgeMoment> border_moments(const Model& model, const mesh::TriangleMesh& mesh, double per_length) {
  std::vector<EdgeMoment> moments;
  for (mesh::TriangleId slot = 0; slot < mesh.num_triangle_slots(); ++slot) {
    for (int k = 0; mesh.is_solid(slot) && k < 3; ++k) {
      if (mesh.neighbour(slot, k) == mesh::kNone) moments.push_back(model.edge_moment(mesh, slot, k, per_length));
    }
  }
  return moments;
}

inline Eigen::Vector3d random_vector(SeededRandom& random, double size) {
  const double a = random.uniform(-size, size);
  const double b = random.uniform(-size, size);
  const double c = random.uniform(-size, size);
  return {a, b, c};
}

inline linear::VertexField random_field(SeededRandom& random, Eigen::Index n, double size) {
  linear::VertexField field(n);
  for (Eigen::Index i = 0; i < n; ++i) field.col(i) = random_vector(random, size);
  return field;
}

// Returns the largest eigenvalue of M^-1 K at `rest`, by power iteration on differences of forces, 1/s^2.
inline double largest_eigenvalue(const Model& model, const linear::VertexField& rest, int iterations) {
  const Eigen::Index n = rest.cols();
  SeededRandom random(31);
  linear::VertexField p = random_field(random, n, 1.0);
  linear::VertexField up(n);
  linear::VertexField down(n);
  double largest = 0.0;
  for (int i = 0; i < iterations; ++i) {
    p /= p.norm();
    constexpr double kStep = 1e-7;
    model.internal_forces(rest + kStep * p, up);
    model.internal_forces(rest - kStep * p, down);
    linear::VertexField Kp = (down - up) / (2.0 * kStep);
    double mass = 0.0;
    for (Eigen::Index k = 0; k < n; ++k) mass += model.mass()[static_cast<std::size_t>(k)] * p.col(k).squaredNorm();
    largest = Kp.cwiseProduct(p).sum() / mass;
    for (Eigen::Index k = 0; k < n; ++k) Kp.col(k) *= model.inverse_mass()[static_cast<std::size_t>(k)];
    p = Kp;
  }
  return largest;
}

inline Eigen::Matrix3d random_rotation(SeededRandom& random) {
  const Eigen::Vector3d axis = random_vector(random, 1.0).normalized();
  return Eigen::AngleAxisd(random.uniform(0.5, 3.0), axis).toRotationMatrix();
}

// E1 over 5 E2, soft in shear, fibres at 0.4 rad.
inline Material orthotropic_cloth() {
  Material m = isotropic(1.0e6, 0.3, 1.0e-3, 300.0);
  m.youngs_modulus_2 = 1.8e5;
  m.shear_modulus = 3.0e4;
  m.direction = 0.4;
  return m;
}

}  // namespace kerf::fem
