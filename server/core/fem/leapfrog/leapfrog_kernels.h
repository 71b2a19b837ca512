#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "server/core/fem/element/bending.h"
#include "server/core/fem/element/bending_layout.h"
#include "server/core/fem/element/material.h"
#include "server/core/fem/leapfrog/membrane_layout.h"
#include "server/core/linear/row_store.h"

// One substep of a leapfrog scheme in vector code, chosen for the processor at run time. The same bits on every
// processor: blocks of a fixed number of lanes, one order of sums, no contraction, exact square roots and divisions.
namespace kerf::fem {

// Positions beside arithmetic in T: of floats, fixed-point numbers, whose differences are exact.
template <typename T>
using PositionOf = std::conditional_t<std::is_same_v<T, float>, std::int32_t, T>;

// Constants of kBlockLanes triangles; see ElementBlock. Without material all 0. Lengths along edges are in the
// unit of positions.
template <typename T>
struct TriangleLanes {
  using Lanes = Lanes16<T>;
  std::array<Lanes, 2> g1{}, g2{};  // 1/unit
  Lanes minus_area{};               // m^2/unit
};

// Constants of kBlockLanes triangles as a step begins, rounded from doubles: the columns of F and F^T F - I. Without
// material all 0.
template <typename T>
struct StartLanes {
  std::array<Lanes16<T>, 3> f1{}, f2{};  // -
  Lanes16<T> e11{}, e22{}, e12{};        // -
};

// As TriangleLanes, of kBlockLanes triangles with Green's strain, by their edges d1, d2 from corner 0 and d3 = d2 - d1:
//   s_k = |d_k|^2 - L_k^2,   W = s.H s / 4,   t = H s,
//   forces on the corners: t1 d1 + t2 d2, t3 d3 - t1 d1, -t2 d2 - t3 d3.
// H = A/2 N^T C N, N taking s / 2 to e: its columns are -(ga gb^T + gb ga^T) / 2 as Voigt strains, ga and gb the shape
// gradients of the edge's ends.
template <typename T>
struct EdgeLanes {
  std::array<Lanes16<T>, 3> length_squared{};  // unit^2, L_k^2
  std::array<Lanes16<T>, 6> stiffness{};       // N/unit^3, H11, H22, H33, H12, H13, H23
};

// Of kBlockLanes triangles: C11, C22, C33, C12, N/m, and damping as in LeapfrogStep.
template <typename T>
struct LawLanes {
  std::array<Lanes16<T>, 5> value{};
};

// e11, e22, 2 e12 of kBlockLanes triangles in the substep before; of Green's strain s_k, unit^2.
template <typename T>
using StrainLanes = std::array<Lanes16<T>, 3>;

// `from`, where corner_x has the vertices, 4 x their id, is by place (see corner_place), the others by
// irregular_lane().
template <typename T>
struct IrregularBlock {
  TriangleLanes<T> triangles;
  StrainLanes<T> before{};
  std::array<std::array<std::int32_t, kBlockLanes>, 3> from{};
};

// The lane of the triangle at a place of an irregular block, and the place at a lane. Four floats of a vertex are as
// long as what vectors can be transposed in: each four lanes are from four places that are four apart.
template <typename T>
constexpr std::size_t irregular_lane(std::size_t place) {
  static_assert(kBlockLanes == 16);
  return std::is_same_v<T, float> ? 4 * (place % 4) + place / 4 : place;
}

// Blocks of vertices of which all forces of quads are made before any of them is moved: enough that no step of the
// arithmetic waits for the one before, few enough to stay in the first cache.
inline constexpr std::size_t kQuadBlocksAhead = 4;

// Arrays of vertices have kBlockLanes x num_blocks entries, and those of positions and velocities, zeros
// beyond both ends as far as offsets reach. "x 4": x, y, z and a 0 of one vertex side by side.
template <typename T>
struct LeapfrogArrays {
  using Position = PositionOf<T>;

  std::size_t num_blocks = 0;  // of vertices
  QuadOffsets offsets{};
  std::array<Position*, 3> x{};
  std::array<T*, 3> v{};                     // m/s
  std::array<T*, 3> remainder{};             // of x, in its unit; null where T is double
  std::array<T*, 3> v_remainder{};           // of v, m/s; null where T is double
  std::array<const T*, 3> mobility{};        // 1/kg, 0 where the component is held, in clusters else 1
  const TriangleLanes<T>* quads = nullptr;   // 2 x num_blocks, or none
  const EdgeLanes<T>* quad_edges = nullptr;  // in their place of Green's strain
  StrainLanes<T>* quads_before = nullptr;    // as either
  // N, at the quad's lowest vertex, corner 0's times -1: of the last quad_ring vertices, a power of two, and behind
  // them once more of the first block, so that a vector may begin anywhere.
  std::array<std::array<T*, 3>, 4> quad_force{};
  std::ptrdiff_t quad_ring = 0;
  std::ptrdiff_t quad_reach = 0;  // blocks, of offsets; 0 without quads
  std::span<IrregularBlock<T>> irregular;
  // As quads and irregular, where positions are displacements since the step began, or null. Co-rotational law alone.
  const StartLanes<T>* quad_start = nullptr;
  const StartLanes<T>* irregular_start = nullptr;
  const EdgeLanes<T>* irregular_edges = nullptr;  // of Green's strain, in place of IrregularBlock::triangles
  const LawLanes<T>* quad_laws = nullptr;         // as quads, or null: those of LeapfrogStep
  const LawLanes<T>* irregular_laws = nullptr;    // as irregular
  const T* mass_damping = nullptr;                // 1/s, of each vertex, or null: lost and scale are those of all
  Position* corner_x = nullptr;                   // x 4, of irregular triangles
  T* corner_force = nullptr;                      // N, x 4, at corner_place(); before the first, four zeros
  T* gathered = nullptr;                          // N, x 4
  const T* extra_force = nullptr;                 // N, x 4, or null
  // Forces of FineTriangles, N, x 4, and their places in corner_force.
  const T* fine_force = nullptr;
  std::span<const std::int32_t> fine_places;
  // Scratch, x + beta v; the first with a block before the first vertex and one behind the last.
  std::array<Position*, 3> bending_x{};
  Position* bending_fours = nullptr;                     // x 4
  std::span<const std::int32_t> num_quads, num_corners;  // of each block of vertices
  const RowStore<CornerPlaces>* corners = nullptr;       // of four vertices
  // Says of each block of vertices whether some of them are in clusters, or null. Such blocks leave their forces in
  // `gathered`, and are moved by leapfrog_move_clusters() alone.
  const std::uint8_t* has_cluster = nullptr;
  const BendingLayout<T>* bending = nullptr;  // null: no bending in this substep
};

template <typename T>
struct LeapfrogStep {
  MembraneLaw membrane_law = MembraneLaw::kCorotational;
  std::array<T, 4> law{};      // N/m: C11, C22, C33, C12
  T damping = 0;               // -, beta / h
  T lost = 0;                  // -, of the velocity
  T scale = 0;                 // s, of forces
  std::array<T, 3> gravity{};  // m/s^2
  T drift = 0;                 // s / unit
  T bending_scale = 0;         // m / unit, bending force counted so many times
  T bending_damping = 0;       // s / unit
};

// Forces at x, kick, drift. `speed`: kBlockLanes largest components of velocity so far, m/s.
template <typename T>
void leapfrog_substep(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step, T* speed);
// Kick and drift of blocks with clusters: those of vertices in clusters by accelerations, m/s^2, which have taken the
// place of forces in `gathered`.
template <typename T>
void leapfrog_move_clusters(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step, T* speed);
// Strains at x as those of the substep before. Returns the largest principal one, -, at least 0; 0 of Green's strain.
template <typename T>
T leapfrog_start(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step);

// Forces of irregular triangles alone, into corner_force. Returns the largest principal strain as leapfrog_start().
double leapfrog_irregular(const LeapfrogArrays<double>& arrays, const LeapfrogStep<double>& step);

}  // namespace kerf::fem
