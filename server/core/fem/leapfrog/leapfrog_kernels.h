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

// One substep of a leapfrog scheme in vector code, chosen for the processor at run time. Results have the same bits on
// every processor: blocks of a fixed number of lanes, one order of sums, no fused multiply-add, exact square roots and
// divisions.
namespace kerf::fem {

// Type of positions if arithmetic is in T. With floats it is a fixed-point number, as differences of these are exact.
template <typename T>
using PositionOf = std::conditional_t<std::is_same_v<T, float>, std::int32_t, T>;

// Constants of kBlockLanes triangles; see ElementBlock. All are 0 without material. Lengths along edges are in the unit
// of positions.
template <typename T>
struct TriangleLanes {
  using Lanes = linear::Lanes16<T>;
  std::array<Lanes, 2> g1{}, g2{};  // 1/unit
  Lanes minus_area{};               // m^2/unit
};

// State of kBlockLanes triangles when the step began, rounded from doubles: the columns f1, f2 of F, and e = F^T F - I.
// All are 0 without material.
template <typename T>
struct StartLanes {
  std::array<linear::Lanes16<T>, 3> f1{}, f2{};  // -
  linear::Lanes16<T> e11{}, e22{}, e12{};        // -
};

// Constants like TriangleLanes for kBlockLanes triangles with Green's strain, by their edges d1, d2 from corner 0 and
// d3 = d2 - d1:
//   s_k = |d_k|^2 - L_k^2,   W = s.H s / 4,   t = H s,
//   forces on the corners: t1 d1 + t2 d2, t3 d3 - t1 d1, -t2 d2 - t3 d3.
// H = A/2 N^T C N, with the area A at rest and the law C. N maps s / 2 to Green's strain (F^T F - I) / 2 as xx, yy and
// 2 xy. Its column k is -(ga gb^T + gb ga^T) / 2 in this form, with the shape gradients ga and gb of the edge's ends.
template <typename T>
struct EdgeLanes {
  std::array<linear::Lanes16<T>, 3> length_squared{};  // unit^2, L_k^2
  std::array<linear::Lanes16<T>, 6> stiffness{};       // N/unit^3, H11, H22, H33, H12, H13, H23
};

// Laws of kBlockLanes triangles: C11, C22, C33, C12, N/m, and damping as in LeapfrogStep.
template <typename T>
struct LawLanes {
  std::array<linear::Lanes16<T>, 5> value{};
};

// Strains e11, e22, 2 e12 of kBlockLanes triangles in the previous substep. With Green's strain they are s_k of
// EdgeLanes, unit^2.
template <typename T>
using StrainLanes = std::array<linear::Lanes16<T>, 3>;

// A block of irregular triangles. `from` holds where their corners begin in corner_x, 4 x the vertex id, in the order
// of MembraneLayout::lanes(). In the other members the triangle at place p of the block is at irregular_lane(p).
template <typename T>
struct IrregularBlock {
  TriangleLanes<T> triangles;
  StrainLanes<T> before{};
  std::array<std::array<std::int32_t, linear::kBlockLanes>, 3> from{};
};

// Returns the lane of the triangle at a place of an irregular block. The mapping is its own inverse, so it also returns
// the place for a lane. Vectors transpose four floats of a vertex at a time, so each four lanes come from four places
// that are four apart.
template <typename T>
constexpr std::size_t irregular_lane(std::size_t place) {
  static_assert(linear::kBlockLanes == 16);
  return std::is_same_v<T, float> ? 4 * (place % 4) + place / 4 : place;
}

// Number of vertex blocks whose quad forces are computed together before their vertices are moved. It is large enough
// that no arithmetic waits for the previous result, and small enough to stay in the first-level cache.
inline constexpr std::size_t kQuadBlocksAhead = 4;

// Arrays of a sweep. Arrays by vertex have kBlockLanes x num_blocks entries. x has zeros beyond both ends of these, as
// far as `offsets` reach. "x 4" means x, y, z and a 0 of one vertex side by side.
template <typename T>
struct LeapfrogArrays {
  using Position = PositionOf<T>;

  std::size_t num_blocks = 0;  // of vertices
  QuadOffsets offsets{};
  std::array<Position*, 3> x{};
  std::array<T*, 3> v{};                     // m/s
  std::array<T*, 3> remainder{};             // of x, in its unit; null if T is double
  std::array<T*, 3> v_remainder{};           // of v, m/s; null if T is double
  std::array<const T*, 3> mobility{};        // 1/kg, 0 in held components; 1 for free components in clusters
  const TriangleLanes<T>* quads = nullptr;   // 2 x num_blocks, or null
  const EdgeLanes<T>* quad_edges = nullptr;  // under Green's strain, in place of quads
  StrainLanes<T>* quads_before = nullptr;    // strains for `quads` or `quad_edges`
  // N, forces of quads on their four corners, [corner][component], at the quad's lowest vertex. That of corner 0 is
  // stored times -1. A ring buffer holds them for the last quad_ring vertices, a power of two. Behind them the first
  // block is repeated, so that a vector may begin anywhere.
  std::array<std::array<T*, 3>, 4> quad_force{};
  std::ptrdiff_t quad_ring = 0;
  std::ptrdiff_t quad_reach = 0;  // blocks that offsets reach; 0 without quads
  std::span<IrregularBlock<T>> irregular;
  // State at the start of the step for `quads` and `irregular`, if positions are displacements since then; otherwise
  // null. Co-rotational law only.
  const StartLanes<T>* quad_start = nullptr;
  const StartLanes<T>* irregular_start = nullptr;
  const EdgeLanes<T>* irregular_edges = nullptr;  // under Green's strain, in place of IrregularBlock::triangles
  const LawLanes<T>* quad_laws = nullptr;         // laws for `quads`; null: all have that of LeapfrogStep
  const LawLanes<T>* irregular_laws = nullptr;    // laws for `irregular`; null as for quad_laws
  const T* mass_damping = nullptr;                // 1/s, by vertex; null: LeapfrogStep::lost and scale hold for all
  Position* corner_x = nullptr;                   // x 4, positions that irregular triangles read
  T* corner_force = nullptr;                      // N, x 4, at corner_place(); four zeros precede the first
  T* gathered = nullptr;                          // N, x 4, sums by vertex of all forces but those of quads
  const T* extra_force = nullptr;                 // N, x 4, further forces on vertices; or null
  // Forces of FineTriangles, N, x 4, and their places in corner_force.
  const T* fine_force = nullptr;
  std::span<const std::int32_t> fine_places;
  // Scratch: the positions x + beta v that bending acts on. bending_x has a block before the first vertex and one
  // behind the last.
  std::array<Position*, 3> bending_x{};
  Position* bending_fours = nullptr;                        // x 4
  std::span<const std::int32_t> num_quads, num_corners;     // of MembraneLayout, by block of vertices
  const linear::RowStore<CornerPlaces>* corners = nullptr;  // of MembraneLayout, a row for every four vertices
  // By block of vertices, non-zero if some of them are in clusters; or null. Such blocks leave their forces in
  // `gathered`, and only leapfrog_move_clusters() moves them.
  const std::uint8_t* has_cluster = nullptr;
  const BendingLayout<T>* bending = nullptr;  // null: no bending in this substep
};

// Constants of one substep of length h. `unit` is the unit of positions; 1 m if T is double.
template <typename T>
struct LeapfrogStep {
  MembraneLaw membrane_law = MembraneLaw::kCorotational;
  std::array<T, 4> law{};      // N/m: C11, C22, C33, C12
  T damping = 0;               // -, beta / h of the membrane
  T lost = 0;                  // -, KickFactors::lost
  T scale = 0;                 // s, KickFactors::scale
  std::array<T, 3> gravity{};  // m/s^2
  T drift = 0;                 // s unit / m, factor from velocities to changes of positions
  T bending_scale = 0;         // m / unit, factor of bending forces, which are computed from positions in units
  T bending_damping = 0;       // s unit / m, beta of bending, for velocities beside positions in units
};

// Computes forces at x, then kicks and drifts the vertices. Raises `speed`, m/s, by lane, to the largest component of
// velocity of the vertices in that lane of their blocks.
template <typename T>
void leapfrog_substep(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step, T* speed);
// Kicks and drifts the blocks with clusters, which leapfrog_substep() leaves out. `gathered` must hold accelerations
// without gravity, m/s^2, for vertices in clusters and forces for the others.
template <typename T>
void leapfrog_move_clusters(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step, T* speed);
// Stores the strains at x as those of the previous substep. Returns the largest principal strain of all triangles, -,
// at least 0, or 0 with Green's strain.
template <typename T>
T leapfrog_start(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step);

// Sets corner_force to the forces of irregular triangles only. Returns their largest principal strain as
// leapfrog_start() does.
double leapfrog_irregular(const LeapfrogArrays<double>& arrays, const LeapfrogStep<double>& step);

}  // namespace kerf::fem
