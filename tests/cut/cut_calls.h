#pragma once

#include <cstdint>
#include <utility>

#include <gtest/gtest.h>

#include "server/cut/cut.h"
#include "server/mesh/grid_mesh.h"
#include "tests/cut/cut_checks.h"

// A test's short ways to meshes and to cuts, each of which is checked.
namespace kerf::cut {

inline mesh::TriangleMesh grid(std::int32_t vertices) {
  return *mesh::make_grid({vertices, vertices, 1.0, 1.0});
}
inline mesh::TriangleMesh jittered(std::int32_t vertices) {
  return *mesh::make_jittered_grid({vertices, vertices, 1.0, 1.0}, 5);
}

inline CutOutcome cut(mesh::TriangleMesh& mesh, const CutRequest& request) {
  const mesh::TriangleMesh before = mesh;
  const Result<CutPlan> planned = plan(mesh, request);
  EXPECT_TRUE(planned.ok()) << planned.error().message;
  Result<CutOutcome> outcome = apply(mesh, *planned);
  EXPECT_TRUE(outcome.ok()) << outcome.error().message;
  if (outcome->status == CutStatus::kApplied) {
    EXPECT_EQ(find_cut_violation(before, mesh, *outcome).value_or(""), "");
  }
  return std::move(*outcome);
}

inline Curve s_curve() {
  return CubicBezier{{{0.1, 0.2}, {0.9, 0.1}, {0.1, 0.95}, {0.9, 0.8}}};
}

}  // namespace kerf::cut
