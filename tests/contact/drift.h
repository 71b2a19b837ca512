#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "server/core/contact/intersections.h"
#include "server/core/contact/self_contact.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/triangle_mesh.h"
#include "tests/contact/lattice_sheet.h"
#include "tests/support/solid_triangles.h"

namespace kerf::contact {

inline constexpr double kApart = 5e-4;  // m, thickness

// Vertices that drift freely between the phases of contact.
class Drift {
 public:
  Drift(mesh::TriangleMesh of, linear::VertexField at) : mesh(std::move(of)), x(std::move(at)), v(x.cols()) {
    v.setZero();
    inverse_mass.assign(static_cast<std::size_t>(x.cols()), 1e3);
    triangles_ = test::solid_triangles(mesh);
    reset();
  }
  // Begins with an object that knows nothing of earlier steps.
  void reset() {
    contact = SelfContact();
    contact.set(mesh);
    contact.set_thickness(kApart);
    contact.set_friction(friction);
  }
  // Makes a step of leapfrog. Calls after_phase() behind each phase.
  template <typename AfterPhase>
  void step(double h, int substeps, const AfterPhase& after_phase) {
    contact.begin({h, substeps, gravity, inverse_mass}, x, v);
    for (int k = 1; k <= substeps; ++k) {
      kick(k == 1 ? 0.5 * h : h);
      x += h * v;
      if (k == substeps) kick(0.5 * h);
      if (k != contact.next_phase()) continue;
      contact.make_phase(x, v);
      after_phase();
    }
  }
  void kick(double duration) {
    for (mesh::VertexId i = 0; i < mesh.num_vertices(); ++i) {
      if (inverse_mass[static_cast<std::size_t>(i)] > 0.0) v.col(i) += duration * gravity;
    }
  }
  [[nodiscard]] std::int64_t num_intersections() { return search_.count(triangles_, x); }
  [[nodiscard]] Eigen::Vector3d momentum() const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (mesh::VertexId i = 0; i < mesh.num_vertices(); ++i)
      sum += v.col(i) / inverse_mass[static_cast<std::size_t>(i)];
    return sum;
  }
  [[nodiscard]] double kinetic_energy() const {
    double sum = 0.0;
    for (mesh::VertexId i = 0; i < mesh.num_vertices(); ++i) {
      sum += 0.5 * v.col(i).squaredNorm() / inverse_mass[static_cast<std::size_t>(i)];
    }
    return sum;
  }

  mesh::TriangleMesh mesh;
  linear::VertexField x, v;  // m, m/s
  std::vector<double> inverse_mass;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  double friction = 0.3;
  SelfContact contact;

 private:
  std::vector<std::array<mesh::VertexId, 3>> triangles_;
  IntersectionSearch search_;
};

// Two squares of cells x cells, the second one of second x second, beside each other in the material plane.
inline mesh::TriangleMesh two_squares(int cells, int second, double edge) {
  const auto is_hole = [cells, second](int i, int j) {
    return i == cells || (i > cells && j >= second) || (i < cells && j >= cells);
  };
  return LatticeSheet{.columns = cells + 1 + second, .rows = std::max(cells, second), .edge = edge, .is_hole = is_hole}
      .mesh();
}
inline bool is_second(const mesh::TriangleMesh& mesh, mesh::VertexId v, int cells, double edge) {
  return mesh.rest_position(v).x() > (cells + 0.5) * edge;
}

}  // namespace kerf::contact
