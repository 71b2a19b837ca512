#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

#include <gtest/gtest.h>

#include "server/core/cut/cut.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "tests/audit/audited_cut.h"
#include "tests/support/trials.h"

// A test's short ways to meshes and to cuts, each of which is checked.
namespace kerf::cut {

// Number of placements of each case on the sheet.
inline const int kPlacements = test::num_trials({.few = 8, .usual = 100, .many = 100});

inline mesh::TriangleMesh grid(std::int32_t vertices) {
  return *mesh::make_grid({vertices, vertices, 1.0, 1.0});
}
inline mesh::TriangleMesh jittered(std::int32_t vertices) {
  return *mesh::make_jittered_grid({vertices, vertices, 1.0, 1.0}, 5);
}

inline CutOutcome cut(mesh::TriangleMesh& mesh, const CutRequest& request) {
  audit::AuditedCut done = audit::cut_and_audit(mesh, request);
  EXPECT_EQ(done.reason, "");
  EXPECT_EQ(done.flaw.value_or(""), "");
  return std::move(done.outcome);
}

// Counts the loops of the opened mesh: border and lips.
inline int count_boundary_loops(const mesh::TriangleMesh& mesh) {
  audit::Census census;
  EXPECT_EQ(audit::find_flaw(mesh, &census).value_or(""), "");
  return static_cast<int>(census.loops);
}

// Neither refined nor relaxed.
inline CutOptions plain() {
  CutOptions options;
  options.min_angle_deg = 0.0;
  options.relax = false;
  return options;
}

inline bool contains(const Stroke& stroke, const Eigen::Vector2d& point) {
  return std::find(stroke.points.begin(), stroke.points.end(), point) != stroke.points.end();
}

inline Curve s_curve() {
  return CubicBezier{{{0.1, 0.2}, {0.9, 0.1}, {0.1, 0.95}, {0.9, 0.8}}};
}

}  // namespace kerf::cut
