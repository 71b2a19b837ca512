#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "server/core/linear/vertex_field.h"

namespace kerf::contact {

// Straight lines on which vertices move, 3 x V.
struct VertexLines {
  const linear::VertexField& x;  // m, at time 0
  const linear::VertexField& v;  // m/s
};

// Distance of vertices from their lines, split into what they have in common and the rest.
struct Stray {
  Eigen::Vector3d mean{0.0, 0.0, 0.0};  // m, from the lines
  double most = 0.0;                    // m, bound of what each vertex has on top of the mean
};

// Sums and bounds of rows of kRow entries, m; lane l has component l % 3. For the implementation.
struct StrayRange {
  static constexpr std::size_t kRow = 24;
  alignas(64) std::array<double, kRow> sum, least, most;
};

// Returns how far all vertices are from their lines after `since` (s), or will be `ahead` (s) later if they move with
// velocities `v` (m/s) from x (m) on. In vector code that is chosen for the processor at run time; results have the
// same bits on every processor.
Stray find_stray(const linear::VertexField& x, const linear::VertexField& v, const VertexLines& lines, double since,
                 double ahead);

}  // namespace kerf::contact
