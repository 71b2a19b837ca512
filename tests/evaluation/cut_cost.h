#pragma once

#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "server/core/cut/cut.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::evaluation {

// A square grid of 1 m, `side` vertices a side, and the random curves that cut it.
struct CutSheet {
  mesh::TriangleMesh mesh;
  std::vector<cut::Curve> curves;
};

// Cuts a grid by a method until `cuts` random curves have cut it.
CutSheet cut_sheet(int side, int cuts, cut::Method method);

// Points along a curve of cut_sheet(), [[x, y], ...], m.
nlohmann::json points_along(const cut::Curve& curve);

// Measures cuts of an uncut grid, one row for each of ten curves: CPU time of the cut with all that follows from it up
// to the next step, the lips as [[x, y, x, y], ...], m, and vertices gained. `has_times` = false leaves the time out.
nlohmann::json measure_cuts(int side, cut::Method method, bool has_times);

}  // namespace kerf::evaluation
