#pragma once

#include <array>
#include <cmath>

#include <Eigen/Core>

#include "server/core/fem/element/element_block.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Loops over the lanes of one block. Each is short, of fixed length and without branches, so that the compiler turns it
// into vector code. Lanes that need a branch (a collapsed triangle) are repaired afterwards, one by one.
using Lane = std::array<double, kLanes>;
using Lane3 = std::array<Lane, 3>;  // [component][lane]

// Polar decomposition F = R S of the triangles of one block; formulas in membrane.h.
struct LaneFrames {
  Lane3 R1, R2;        // -, columns of R
  Lane S11, S22, S12;  // -
  Lane inverse_trace;  // 1 / tr S; 1 where tr S is 0
};

// Values of a vertex field at corners 1 and 2 minus that at corner 0.
struct LaneEdges {
  Lane3 d1, d2;
};

inline void gather_edges(const ElementBlock& block, const linear::VertexField& x, LaneEdges& edges) {
  const double* data = x.data();
  for (std::size_t l = 0; l < kLanes; ++l) {
    const double* x0 = data + 3 * static_cast<std::ptrdiff_t>(block.vertex[0][l]);
    const double* x1 = data + 3 * static_cast<std::ptrdiff_t>(block.vertex[1][l]);
    const double* x2 = data + 3 * static_cast<std::ptrdiff_t>(block.vertex[2][l]);
    for (std::size_t c = 0; c < 3; ++c) {
      edges.d1[c][l] = x1[c] - x0[c];
      edges.d2[c][l] = x2[c] - x0[c];
    }
  }
}

// Sets f1, f2 to the columns of [d1, d2] Dm^-1.
inline void multiply_by_dm_inverse(const ElementBlock& block, const LaneEdges& d, Lane3& f1, Lane3& f2) {
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t l = 0; l < kLanes; ++l) {
      f1[c][l] = d.d1[c][l] * block.g1[0][l] + d.d2[c][l] * block.g2[0][l];
      f2[c][l] = d.d1[c][l] * block.g1[1][l] + d.d2[c][l] * block.g2[1][l];
    }
  }
}

// Sets the frame of a lane whose triangle has collapsed to a line or a point. Any unit vector across the line serves as
// normal.
void repair_collapsed_lane(const Lane3& f1, const Lane3& f2, std::size_t lane, LaneFrames& frames);

// Quantities of one lane: n = f1 x f2, its square, and F^T F.
struct LaneMetric {
  double n1, n2, n3, d_squared, c11, c22, c12;
};
inline LaneMetric metric_of(const Lane3& f1, const Lane3& f2, std::size_t l) {
  const double n1 = f1[1][l] * f2[2][l] - f1[2][l] * f2[1][l];
  const double n2 = f1[2][l] * f2[0][l] - f1[0][l] * f2[2][l];
  const double n3 = f1[0][l] * f2[1][l] - f1[1][l] * f2[0][l];
  const double c11 = f1[0][l] * f1[0][l] + f1[1][l] * f1[1][l] + f1[2][l] * f1[2][l];
  const double c22 = f2[0][l] * f2[0][l] + f2[1][l] * f2[1][l] + f2[2][l] * f2[2][l];
  const double c12 = f1[0][l] * f2[0][l] + f1[1][l] * f2[1][l] + f1[2][l] * f2[2][l];
  return {n1, n2, n3, n1 * n1 + n2 * n2 + n3 * n3, c11, c22, c12};
}

inline void polar_decomposition(const Lane3& __restrict f1, const Lane3& __restrict f2, LaneFrames& __restrict frames) {
  // kCollapsedSquared: squared ratio of |f1 x f2| to |f1|^2 + |f2|^2 below which the normal is mere rounding.
  // kPointSquared catches triangles shrunk to 1e-15 of their size.
  constexpr double kCollapsedSquared = 1e-24;
  constexpr double kPointSquared = 1e-60;
  constexpr double kTiny = 1e-150;
  Lane excess;  // > 0: regular
  for (std::size_t l = 0; l < kLanes; ++l) {
    const auto [n1, n2, n3, d_squared, c11, c22, c12] = metric_of(f1, f2, l);
    const double trace = c11 + c22;
    excess[l] = d_squared - (kCollapsedSquared * (trace * trace) + kPointSquared);
    const double d = std::sqrt(d_squared);
    const double inverse_d = 1.0 / (d + kTiny);
    const double inverse_s = 1.0 / (std::sqrt(trace + 2.0 * d) + kTiny);
    frames.inverse_trace[l] = inverse_s;
    frames.S11[l] = (c11 + d) * inverse_s;
    frames.S22[l] = (c22 + d) * inverse_s;
    frames.S12[l] = c12 * inverse_s;
    const double u1 = n1 * inverse_d;
    const double u2 = n2 * inverse_d;
    const double u3 = n3 * inverse_d;
    frames.R1[0][l] = (f1[0][l] + (f2[1][l] * u3 - f2[2][l] * u2)) * inverse_s;
    frames.R1[1][l] = (f1[1][l] + (f2[2][l] * u1 - f2[0][l] * u3)) * inverse_s;
    frames.R1[2][l] = (f1[2][l] + (f2[0][l] * u2 - f2[1][l] * u1)) * inverse_s;
    frames.R2[0][l] = (f2[0][l] + (u2 * f1[2][l] - u3 * f1[1][l])) * inverse_s;
    frames.R2[1][l] = (f2[1][l] + (u3 * f1[0][l] - u1 * f1[2][l])) * inverse_s;
    frames.R2[2][l] = (f2[2][l] + (u1 * f1[1][l] - u2 * f1[0][l])) * inverse_s;
  }
  for (std::size_t l = 0; l < kLanes; ++l) {
    if (!(excess[l] > 0.0)) repair_collapsed_lane(f1, f2, l, frames);
  }
}

// Sets the frames of the triangles of the block at x (3 x V, m).
inline void frames_at(const ElementBlock& block, const linear::VertexField& x, LaneFrames& frames) {
  LaneEdges dx;
  Lane3 f1;
  Lane3 f2;
  gather_edges(block, x, dx);
  multiply_by_dm_inverse(block, dx, f1, f2);
  polar_decomposition(f1, f2, frames);
}

}  // namespace kerf::fem
