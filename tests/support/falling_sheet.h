#pragma once

#include <cmath>
#include <ctime>
#include <memory>
#include <vector>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/mesh/build/grid_mesh.h"

namespace kerf::test {

// A sheet of 1 m x 1 m with 20 x 20 vertices that falls from the horizontal, with two corners pinned. It crumples after
// some 0.4 s.
struct FallingSheet {
  static constexpr int kSide = 20;

  explicit FallingSheet(const fem::Material& material)
      : mesh(mesh::make_grid({.num_x = kSide, .num_y = kSide}).value()), model(mesh, material) {
    start.x = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
    start.v = start.x;
    for (int v = 0; v < mesh.num_vertices(); ++v) start.x.col(v).head<2>() = mesh.rest_position(v);
    for (const int v : {kSide * (kSide - 1), kSide * kSide - 1}) {
      loads.pins.push_back({v, start.x.col(v), Eigen::Vector3d::Zero()});
    }
  }

  // Returns the energy minus the energy at the start, J; 0 for an exact motion without damping.
  [[nodiscard]] double energy_gain(const fem::State& state) const {
    return model.energies(state, loads.gravity).total() - model.energies(start, loads.gravity).total();
  }

  mesh::TriangleMesh mesh;
  fem::Model model;
  fem::State start;
  fem::Loads loads;
};

struct Fall {
  std::vector<fem::State> states;  // one at the end of each interval
  int solves = 0;
  int substeps = 0;
  int repaired = 0;        // steps
  int not_converged = 0;   // steps
  double simulated = 0.0;  // s; less than requested if max_substeps was too few
  double seconds = 0.0;    // CPU time
};

// Lets a sheet fall in steps of 1 / rate (Hz). `interval`: seconds, a whole number of steps.
inline Fall fall(const FallingSheet& sheet, const fem::IntegratorOptions& options, double rate, double interval,
                 int num_intervals) {
  const std::unique_ptr<fem::Integrator> integrator = fem::make_integrator(options);
  integrator->rebuild(sheet.model);
  Fall result;
  fem::State state = sheet.start;
  const std::clock_t begin = std::clock();
  for (int k = 0; k < num_intervals; ++k) {
    for (long i = 0; i < std::lround(interval * rate); ++i) {
      const fem::StepStats stats = integrator->step(sheet.model, sheet.loads, 1.0 / rate, nullptr, state);
      result.solves += stats.newton_iterations;
      result.substeps += stats.substeps;
      result.simulated += stats.simulated;
      if ((stats.flags & fem::kRepaired) != 0) ++result.repaired;
      if ((stats.flags & fem::kNotConverged) != 0) ++result.not_converged;
    }
    result.states.push_back(state);
  }
  result.seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  return result;
}

// Returns the largest distance, m, between the two positions of a vertex.
inline double largest_distance(const fem::State& a, const fem::State& b) {
  return (a.x - b.x).colwise().norm().maxCoeff();
}

}  // namespace kerf::test
