#pragma once

#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/statics/equilibrium.h"
#include "server/core/mesh/build/mesh_import.h"
#include "tests/accuracy/reference.h"

namespace kerf::accuracy {

inline constexpr std::array<const char*, 3> kMeshes{"coarse", "medium", "fine"};

// (num_x + 1) x (num_y + 1) vertices, x fastest, of the image of the unit square; cells are halved from lower
// right to upper left, which in Cook's membrane is the shorter diagonal.
template <typename Map>
mesh::TriangleMesh mapped_grid(int num_x, int num_y, const Map& map) {
  mesh::IndexedMesh grid;
  grid.rest.resize(2, (num_x + 1) * (num_y + 1));
  grid.triangles.resize(3, 2 * num_x * num_y);
  for (int j = 0; j <= num_y; ++j) {
    for (int i = 0; i <= num_x; ++i) {
      const Eigen::Vector2d X = map(static_cast<double>(i) / num_x, static_cast<double>(j) / num_y);
      grid.rest.col(j * (num_x + 1) + i) = X;
    }
  }
  int t = 0;
  for (int j = 0; j < num_y; ++j) {
    for (int i = 0; i < num_x; ++i) {
      const int a = j * (num_x + 1) + i;
      const int c = a + num_x + 2;
      grid.triangles.col(t++) = Eigen::Vector3i(a, a + 1, c - 1);
      grid.triangles.col(t++) = Eigen::Vector3i(a + 1, c, c - 1);
    }
  }
  return mesh::import_mesh(grid).value();
}

// x: where to start; becomes the equilibrium.
inline fem::EquilibriumStats settle(const fem::Model& model, const fem::Loads& loads, linear::VertexField& x) {
  fem::EquilibriumSolver solver({});
  solver.rebuild(model);
  const fem::EquilibriumStats stats = solver.solve(model, loads, nullptr, x);
  EXPECT_TRUE(stats.converged) << stats.residual << " after " << stats.iterations;
  std::printf("  %d vertices: %d iterations, residual %.1e\n", model.num_vertices(), stats.iterations, stats.residual);
  return stats;
}

// A strip along x in the plane z = 0, clamped at x = 0, in its undeformed state.
struct Cantilever {
  Cantilever(const Reference& reference, const char* breadth, int segments, int across)
      : length(reference.geometry("L")),
        mesh(mapped_grid(
            segments, across,
            [&](double a, double b) { return Eigen::Vector2d(a * length, b * reference.geometry(breadth)); })),
        model(mesh, reference.material()),
        x(mesh.num_vertices()) {
    loads.gravity.setZero();
    loads.external_forces = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
    std::vector<fem::Clamp> clamps;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
      x.col(v) << mesh.rest_position(v), 0.0;
      if (v % (segments + 1) == segments) end.push_back(v);
      if (v % (segments + 1) != 0) continue;
      loads.pins.push_back({v, x.col(v), Eigen::Vector3d::Zero()});
      clamps.push_back({v, Eigen::Matrix<double, 3, 2>::Identity()});
    }
    model.set_clamps(mesh, clamps);
    model.bend_by_angles(mesh);
    rest = x;
  }
  // Returns the position of the end, m: the mean over its vertices.
  [[nodiscard]] Eigen::Vector3d tip() const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const int v : end) sum += x.col(v) - rest.col(v);
    return sum / static_cast<double>(end.size());
  }

  double length;  // m
  mesh::TriangleMesh mesh;
  fem::Model model;
  linear::VertexField x, rest;
  fem::Loads loads;
  std::vector<int> end;  // vertices at x = L, in order
};

}  // namespace kerf::accuracy
