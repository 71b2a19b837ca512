#pragma once

// Meshes, states and steps for the tests of the explicit integrator's vector code.

#include <array>
#include <vector>

#include "server/core/cut/cut.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "tests/fem/integrator_cases.h"

namespace kerf::fem {

inline std::vector<mesh::TriangleId> slit(mesh::TriangleMesh& mesh, double y) {
  const Result<cut::CutPlan> plan = cut::plan(mesh, {cut::Polyline{{{0.2, y}, {0.83, y + 0.04}}}, {}, {}});
  EXPECT_TRUE(plan.ok());
  Result<cut::CutOutcome> outcome = cut::apply(mesh, *plan);
  EXPECT_TRUE(outcome.ok());
  return outcome->edit.rewritten_triangles;
}

// Regular, irregular, both, and long rows. Forces of some blocks of quads are kept at a time: rows of 120 vertices need
// 16 blocks, a power of two, and those of 140 need 17.
inline std::vector<mesh::TriangleMesh> meshes() {
  std::vector<mesh::TriangleMesh> all{square_grid(19), jittered_square(19), square_grid(19)};
  slit(all.back(), 0.37);
  slit(all.back(), 0.61);
  for (const int num_x : {120, 140, 301}) {
    const double width = 0.05 * num_x;
    all.push_back(mesh::make_grid({.num_x = num_x, .num_y = 5, .width = width, .height = 0.2}).value());
  }
  return all;
}

inline constexpr std::array<MembraneLaw, 2> kLaws{MembraneLaw::kCorotational, MembraneLaw::kGreen};

inline IntegratorOptions options_of(Precision precision) {
  IntegratorOptions options;
  options.kind = IntegratorKind::kExplicit;
  options.precision = precision;
  return options;
}

inline State crumpled_state(const mesh::TriangleMesh& mesh) {
  SeededRandom random(11);
  State state = rest_state(mesh);
  state.x += random_field(random, state.x.cols(), 0.01);
  state.v = random_field(random, state.x.cols(), 0.2);
  return state;
}

// Nearly at rest, of soft_cloth() and stiffer ones.
inline State quiet_state(const mesh::TriangleMesh& mesh) {
  SeededRandom random(13);
  State state = rest_state(mesh);
  state.x += random_field(random, state.x.cols(), 1e-4);
  state.v = random_field(random, state.x.cols(), 5e-5);
  return state;
}

inline State stepped(const Model& model, Integrator& integrator, State state, int ticks, const Loads& loads = Loads()) {
  for (int i = 0; i < ticks; ++i) {
    EXPECT_EQ(integrator.step(model, loads, kTick, nullptr, state).flags, 0U);
  }
  return state;
}

}  // namespace kerf::fem
