#pragma once

// Sheets cut so that some of their triangles are tiny, and steps of them with clusters.
#include "server/core/fem/step/explicit_integrator.h"
#include "tests/fem/fixture.h"
#include "tests/fem/integrator_cases.h"
#include "tests/support/random_cuts.h"

namespace kerf::fem {

inline IntegratorOptions explicit_options(Precision precision, bool has_local_inertia = true) {
  IntegratorOptions options;
  options.kind = IntegratorKind::kExplicit;
  options.precision = precision;
  options.has_local_inertia = has_local_inertia;
  return options;
}

// 1 m x 1 m, of 50 x 50 vertices, with random cuts.
struct CutSheet {
  explicit CutSheet(std::size_t num_cuts, const Material& material = *find_preset("demo"), std::uint64_t seed = 1)
      : mesh(square_grid(50)), model(mesh, material), cuts(seed, mesh, model) {
    cuts.make(num_cuts);
  }
  [[nodiscard]] Loads pinned_at_corners() const {
    Loads loads;
    for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
      const Eigen::Vector2d p = mesh.rest_position(v);
      if (!mesh.has_material(v) || p.y() < 1.0 || (p.x() > 0.0 && p.x() < 1.0)) continue;
      loads.pins.push_back({v, Eigen::Vector3d(p.x(), p.y(), 0.0)});
    }
    return loads;
  }
  // Pins the upper edge where the state has it.
  [[nodiscard]] Loads pinned_at_top(const State& state) const {
    Loads loads;
    for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
      if (mesh.has_material(v) && mesh.rest_position(v).y() >= 1.0) loads.pins.push_back({v, state.x.col(v)});
    }
    return loads;
  }
  mesh::TriangleMesh mesh;
  Model model;
  test::RandomCuts cuts;
};

}  // namespace kerf::fem
