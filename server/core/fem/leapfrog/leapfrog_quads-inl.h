// Forces of quads for leapfrog_kernels.cc. A quad is the pair of regular triangles stored at one vertex, see
// MembraneLayout. Compiled once for each instruction set.
#if defined(KERF_FEM_LEAPFROG_QUADS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KERF_FEM_LEAPFROG_QUADS_INL_H
#undef KERF_FEM_LEAPFROG_QUADS_INL_H
#else
#define KERF_FEM_LEAPFROG_QUADS_INL_H
#endif

#include <array>
#include <cstddef>

#include <hwy/highway.h>

#include "server/core/fem/leapfrog/leapfrog_kernels.h"
#include "server/core/fem/leapfrog/leapfrog_triangles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kerf::fem {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

template <class DP>
HWY_INLINE Vec3<hn::Vec<DP>> load3(DP d, const std::array<hn::TFromD<DP>*, 3>& from, std::ptrdiff_t at) {
  return {hn::LoadU(d, from[0] + at), hn::LoadU(d, from[1] + at), hn::LoadU(d, from[2] + at)};
}
template <class D>
HWY_INLINE void store3(D d, const Vec3<hn::Vec<D>>& value, const std::array<hn::TFromD<D>*, 3>& to, std::ptrdiff_t at) {
  hn::Store(value.x, d, to[0] + at);
  hn::Store(value.y, d, to[1] + at);
  hn::Store(value.z, d, to[2] + at);
}

template <typename T>
HWY_INLINE std::ptrdiff_t in_ring(const LeapfrogArrays<T>& arrays, std::ptrdiff_t at) {
  return at & (arrays.quad_ring - 1);
}
template <class D>
HWY_INLINE void store_quad_force(D d, const LeapfrogArrays<hn::TFromD<D>>& arrays, std::size_t k,
                                 const Vec3<hn::Vec<D>>& force, std::ptrdiff_t place) {
  store3(d, force, arrays.quad_force[k], place);
  if (place < static_cast<std::ptrdiff_t>(linear::kBlockLanes)) {
    store3(d, force, arrays.quad_force[k], place + arrays.quad_ring);
  }
}

template <typename T>
void clear_quad_forces(const LeapfrogArrays<T>& arrays, std::ptrdiff_t block) {
  const LanesOf<T> d;
  const Vec3<hn::Vec<LanesOf<T>>> none{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  const std::ptrdiff_t place = in_ring(arrays, block * static_cast<std::ptrdiff_t>(linear::kBlockLanes));
  for (std::size_t l = 0; l < linear::kBlockLanes; l += hn::Lanes(d)) {
    for (std::size_t k = 0; k < 4; ++k) store_quad_force(d, arrays, k, none, place + static_cast<std::ptrdiff_t>(l));
  }
}

template <class D, class V = hn::Vec<D>>
HWY_INLINE std::array<Vec3<V>, 3> quad_edges(D d, const LeapfrogArrays<hn::TFromD<D>>& arrays, std::ptrdiff_t at) {
  const hn::Rebind<PositionOf<hn::TFromD<D>>, D> dp;
  const auto x0 = load3(dp, arrays.x, at);
  return {edge(d, load3(dp, arrays.x, at + arrays.offsets[0]), x0),
          edge(d, load3(dp, arrays.x, at + arrays.offsets[1]), x0),
          edge(d, load3(dp, arrays.x, at + arrays.offsets[2]), x0)};
}

// Sets the deformation gradients of the two triangles of each quad of a block.
template <typename T>
HWY_NOINLINE void set_quad_gradients(const LeapfrogArrays<T>& arrays, std::size_t block, StretchLanes<T>* to) {
  const LanesOf<T> d;
  const TriangleLanes<T>* const lanes = arrays.quads + 2 * block;
  for (std::size_t l = 0; l < linear::kBlockLanes; l += hn::Lanes(d)) {
    const auto edges = quad_edges(d, arrays, static_cast<std::ptrdiff_t>(block * linear::kBlockLanes + l));
    set_gradients(d, lanes[0], l, edges[0], edges[1], to[0]);
    set_gradients(d, lanes[1], l, edges[1], edges[2], to[1]);
  }
}

template <typename T>
HWY_NOINLINE void set_quad_gradients_from_start(const LeapfrogArrays<T>& arrays, std::size_t block,
                                                StretchLanes<T>* to) {
  const LanesOf<T> d;
  const TriangleLanes<T>* const lanes = arrays.quads + 2 * block;
  const StartLanes<T>* const start = arrays.quad_start + 2 * block;
  for (std::size_t l = 0; l < linear::kBlockLanes; l += hn::Lanes(d)) {
    const auto edges = quad_edges(d, arrays, static_cast<std::ptrdiff_t>(block * linear::kBlockLanes + l));
    set_gradients(d, lanes[0], start[0], l, edges[0], edges[1], to[0]);
    set_gradients(d, lanes[1], start[1], l, edges[1], edges[2], to[1]);
  }
}

template <MembraneLaw kLaw, typename T>
HWY_NOINLINE void set_quad_forces(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step, std::size_t block,
                                  StretchLanes<T>* stretches) {
  const LanesOf<T> d;
  const auto common = common_law(d, step);
  const LawLanes<T>* const laws = arrays.quad_laws == nullptr ? nullptr : arrays.quad_laws + 2 * block;
  StrainLanes<T>* const before = arrays.quads_before + 2 * block;
  using V = hn::Vec<LanesOf<T>>;
  for (std::size_t l = 0; l < linear::kBlockLanes; l += hn::Lanes(d)) {
    const auto at = static_cast<std::ptrdiff_t>(block * linear::kBlockLanes + l);
    std::array<CornerForces<V>, 2> forces;
    if constexpr (kLaw == MembraneLaw::kGreen) {
      const EdgeLanes<T>* const lanes = arrays.quad_edges + 2 * block;
      const auto edges = quad_edges(d, arrays, at);
      for (std::size_t k = 0; k < 2; ++k) {
        const V damping = laws == nullptr ? common.damping : damping_of(d, laws[k], l);
        forces[k] = edge_forces(d, damping, lanes[k], l, edges[k], edges[k + 1], before[k]);
      }
    } else {
      const TriangleLanes<T>* const lanes = arrays.quads + 2 * block;
      for (std::size_t k = 0; k < 2; ++k) {
        forces[k] =
            corner_forces(d, laws == nullptr ? common : law_of(d, laws[k], l), lanes[k], l, stretches[k], before[k]);
      }
    }
    const Vec3<V> middle = plus(forces[0].force2, forces[1].force1);
    const Vec3<V> others = plus(plus(forces[0].force1, forces[1].force2), middle);
    const std::ptrdiff_t place = in_ring(arrays, at);
    store_quad_force(d, arrays, 0, others, place);
    store_quad_force(d, arrays, 1, forces[0].force1, place);
    store_quad_force(d, arrays, 2, middle, place);
    store_quad_force(d, arrays, 3, forces[1].force2, place);
  }
}

// Computes the quad forces of blocks [first, last), at most kQuadBlocksAhead of them.
template <MembraneLaw kLaw, typename T>
void quad_forces(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step, std::size_t first, std::size_t last) {
  StretchLanes<T> stretches[2 * kQuadBlocksAhead];
  if constexpr (kLaw == MembraneLaw::kCorotational) {
    const bool from_start = arrays.quad_start != nullptr;
    std::size_t num_stretches = 0;
    for (std::size_t b = first; b < last; ++b) {
      if (arrays.num_quads[b] == 0) continue;
      from_start ? set_quad_gradients_from_start(arrays, b, stretches + num_stretches)
                 : set_quad_gradients(arrays, b, stretches + num_stretches);
      num_stretches += 2;
    }
    from_start ? set_strains_from_start(stretches, num_stretches) : set_strains(stretches, num_stretches);
  }
  StretchLanes<T>* next = stretches;
  for (std::size_t b = first; b < last; ++b) {
    if (arrays.num_quads[b] == 0) {
      clear_quad_forces(arrays, static_cast<std::ptrdiff_t>(b));
    } else {
      set_quad_forces<kLaw>(arrays, step, b, next);
      next += 2;
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::fem
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
