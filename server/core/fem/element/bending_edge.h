#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "server/core/fem/element/bending.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

// Term of the bending energy at an edge between two patches. Their quadratics meet in value but not in slope, and a
// moment that crosses the edge does work on the kink. Without that work constant moments are out of balance on
// irregular meshes. A plate is then too soft by a tenth or more, however fine the mesh is. The term is that of the
// symmetric interior penalty method (Engel et al. 2002, "Continuous/discontinuous finite element approximations of
// fourth-order elliptic problems", section 3), with slopes taken in the middle of the edge of length l:
//   E = l J.{m} + p J.J,  J = jump of the slope across the edge, m = n.M n, {m} the mean of both sides,
//   p = kKinkPenalty l^2 (n n).D (n n) (1 / A_1 + 1 / A_2) / 4.
// The terms of x, y and z are added. J is 0 for quadratics wherever the fit is exact, so the energy of constant
// curvature is unchanged. In a grid with parallel diagonals J is 0 at every inner edge. Such an edge has no term at
// all.
struct BendingEdge {
  // 0..5 are the patch of the first triangle, as in BendingPatch. 6 and 7 are the two vertices of the second patch that
  // the first one lacks. A place is kNone if its vertex is missing, or has an earlier place already.
  std::array<mesh::VertexId, 8> vertex{mesh::kNone, mesh::kNone, mesh::kNone, mesh::kNone,
                                       mesh::kNone, mesh::kNone, mesh::kNone, mesh::kNone};
  int first_edge = 0;                      // corner of the first triangle opposite the edge
  std::array<std::uint8_t, 2> material{};  // of each of the two triangles, see ElementBlock::material
  // E = sum over x,y,z of (kink.x) (load.x), hence Q_ab = kink_a load_b + load_a kink_b.
  std::array<double, 8> kink{};  // 1/m; coefficients of J by vertex
  std::array<double, 8> load{};  // N; coefficients of l {m} + p J by vertex

  [[nodiscard]] double at(std::size_t a, std::size_t b) const { return kink[a] * load[b] + load[a] * kink[b]; }
};

// -, factor of the penalty p. It keeps the energy of a triangle T, with its share of the terms at its three edges, from
// being negative. Let p_T be the share of T in p, and m its normal moment. Each edge then needs
//   1/2 |l J m| <= p_T J^2 + (A_T / 2 kappa.D kappa) / 3,
// which holds from 3/2 on.
inline constexpr double kKinkPenalty = 1.5;

// -, largest coefficient of J times l up to which an edge needs no term.
inline constexpr double kNegligibleKink = 1e-6;

// Contribution of one patch to the term at one of its edges; PatchLanes computes it. Arrays are by vertex of
// BendingPatch.
struct BendingSide {
  std::array<double, 6> slope{};   // 1/m; coefficients of the derivative of x along the outward normal, in the middle
                                   // of the edge
  std::array<double, 6> moment{};  // N/m; coefficients of the normal moment m
  double length = 0.0;             // m; l
  double penalty = 0.0;            // N m; share of this patch in p
};

// Returns the place in BendingEdge::vertex of each vertex of the second triangle's patch. The edge is opposite corner
// `first_edge` of the first and `second_edge` of the second triangle.
std::array<std::size_t, 6> places_of_second(std::size_t first_edge, std::size_t second_edge);

// Sets kink and load of `made` from both sides of its edge. made.vertex must be set, and `places` come from
// places_of_second(). Returns true if the edge needs a term, see kNegligibleKink.
bool join_sides(const BendingSide& first, const BendingSide& second, const std::array<std::size_t, 6>& places,
                BendingEdge& made);

}  // namespace kerf::fem
