#include "server/core/fem/leapfrog/leapfrog_kernels.h"

#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/fem/leapfrog/leapfrog_kernels.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "server/core/fem/leapfrog/leapfrog_gather-inl.h"
#include "server/core/fem/leapfrog/leapfrog_quads-inl.h"
#include "server/core/fem/leapfrog/leapfrog_triangles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kerf::fem {
namespace HWY_NAMESPACE {
namespace {

// Sets `gathered` to the bending forces of the vertices of a block by the diagonals of the bending matrix, unscaled.
template <typename T>
HWY_NOINLINE void sum_bending_diagonals(const LeapfrogArrays<T>& arrays, std::size_t block) {
  const LanesOf<T> d;
  const LanesOf<PositionOf<T>> dp;
  const std::span<const std::int32_t> offsets = arrays.bending->offsets(block);
  const std::span<const linear::Lanes16<T>> diagonals = arrays.bending->diagonals(block);
  for (std::size_t l = 0; l < linear::kBlockLanes; l += hn::Lanes(d)) {
    const auto at = static_cast<std::ptrdiff_t>(block * linear::kBlockLanes + l);
    const auto xi = load3(dp, arrays.bending_x, at);
    Vec3<hn::Vec<LanesOf<T>>> sum{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    for (std::size_t k = 0; k < offsets.size(); ++k) {
      const auto value = hn::Load(d, &diagonals[k].lane[l]);
      const auto xj = load3(dp, arrays.bending_x, at + offsets[k]);
      sum.x = hn::Add(sum.x, hn::Mul(value, converted(d, hn::Sub(xi.x, xj.x))));
      sum.y = hn::Add(sum.y, hn::Mul(value, converted(d, hn::Sub(xi.y, xj.y))));
      sum.z = hn::Add(sum.z, hn::Mul(value, converted(d, hn::Sub(xi.z, xj.z))));
    }
    hn::StoreInterleaved4(sum.x, sum.y, sum.z, hn::Zero(d), d, arrays.gathered + 4 * at);
  }
}

// Sets `gathered` for the vertices of a block to bending forces plus forces of irregular corners plus extra_force.
template <typename T>
HWY_INLINE void gather(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step, std::size_t block) {
  const bool bends = arrays.bending != nullptr;
  if (bends) {
    const bool has_diagonals = !arrays.bending->offsets(block).empty();
    if (has_diagonals) sum_bending_diagonals(arrays, block);
    bending_by_rows(arrays, step, block, has_diagonals);
    if (arrays.num_corners[block] == 0 && arrays.extra_force == nullptr) return;
  }
  add_corners(arrays, block, bends);
}

template <class D>
HWY_INLINE hn::Vec<D> drifted(D /*d*/, hn::Vec<D> x, hn::Vec<D> change, double* /*remainder*/) {
  return hn::Add(x, change);
}
template <class D, class DP = hn::Rebind<std::int32_t, D>>
HWY_INLINE hn::Vec<DP> drifted(D d, hn::Vec<DP> x, hn::Vec<D> change, float* remainder) {
  const auto all = hn::Add(change, hn::Load(d, remainder));
  const auto whole = hn::NearestInt(all);
  hn::Store(hn::Sub(all, hn::ConvertTo(d, whole)), d, remainder);
  return hn::Add(x, whole);
}

template <class D>
HWY_INLINE hn::Vec<D> kicked(D /*d*/, hn::Vec<D> v, hn::Vec<D> change, double* /*remainder*/) {
  return hn::Add(v, change);
}
// Adds `change` to v. The rounding error of the sum becomes the remainder, which is added to the next change.
template <class D>
HWY_INLINE hn::Vec<D> kicked(D d, hn::Vec<D> v, hn::Vec<D> change, float* remainder) {
  const auto all = hn::Add(change, hn::Load(d, remainder));
  const auto after = hn::Add(v, all);
  hn::Store(hn::Sub(all, hn::Sub(after, v)), d, remainder);
  return after;
}

// Sets bending_x to x + beta v.
template <typename T>
HWY_NOINLINE void set_bending_positions(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step) {
  const LanesOf<T> d;
  const LanesOf<PositionOf<T>> dp;
  const auto beta = hn::Set(d, step.bending_damping);
  const bool has_rest = arrays.bending->has_rest();
  for (std::size_t i = 0; i < linear::kBlockLanes * arrays.num_blocks; i += hn::Lanes(d)) {
    const auto at = static_cast<std::ptrdiff_t>(i);
    auto x = load3(dp, arrays.x, at);
    if (step.bending_damping > 0) {
      alignas(64) T none[linear::kBlockLanes] = {};
      x.x = drifted(d, x.x, hn::Mul(beta, hn::Load(d, arrays.v[0] + at)), none);
      std::memset(none, 0, sizeof none);
      x.y = drifted(d, x.y, hn::Mul(beta, hn::Load(d, arrays.v[1] + at)), none);
      std::memset(none, 0, sizeof none);
      x.z = drifted(d, x.z, hn::Mul(beta, hn::Load(d, arrays.v[2] + at)), none);
    }
    store3(dp, x, arrays.bending_x, at);
    if (has_rest) hn::StoreInterleaved4(x.x, x.y, x.z, hn::Zero(dp), dp, arrays.bending_fours + 4 * i);
  }
}

// Returns forces of the vertices from i on: those of quads, plus `gathered` if `has_gathered`.
template <class D, class V = hn::Vec<D>>
HWY_INLINE std::array<V, 3> forces_at(D d, const LeapfrogArrays<hn::TFromD<D>>& arrays, bool has_gathered,
                                      std::size_t i) {
  std::array<V, 4> sum{hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  if (has_gathered) hn::LoadInterleaved4(d, arrays.gathered + 4 * i, sum[0], sum[1], sum[2], sum[3]);
  if (arrays.quads_before == nullptr) return {sum[0], sum[1], sum[2]};
  const auto at = static_cast<std::ptrdiff_t>(i);
  const std::array<std::ptrdiff_t, 4> from{in_ring(arrays, at), in_ring(arrays, at - arrays.offsets[0]),
                                           in_ring(arrays, at - arrays.offsets[1]),
                                           in_ring(arrays, at - arrays.offsets[2])};
  for (std::size_t c = 0; c < 3; ++c) {
    const V near =
        hn::Sub(hn::LoadU(d, arrays.quad_force[1][c] + from[1]), hn::Load(d, arrays.quad_force[0][c] + from[0]));
    const V far =
        hn::Add(hn::LoadU(d, arrays.quad_force[2][c] + from[2]), hn::LoadU(d, arrays.quad_force[3][c] + from[3]));
    sum[c] = hn::Add(sum[c], hn::Add(near, far));
  }
  return {sum[0], sum[1], sum[2]};
}

// Kicks and drifts the vertices from i on.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void move_at(D d, const LeapfrogArrays<hn::TFromD<D>>& arrays, const LeapfrogStep<hn::TFromD<D>>& step,
                        std::size_t i, const std::array<V, 3>& forces, hn::TFromD<D>* speed) {
  using T = hn::TFromD<D>;
  const hn::Rebind<PositionOf<T>, D> dp;
  V lost = hn::Set(d, step.lost);
  V scale = hn::Set(d, step.scale);
  if (arrays.mass_damping != nullptr) {
    const V one = hn::Set(d, T{1});
    const V half = hn::Mul(hn::Set(d, step.scale * T{0.5}), hn::Load(d, arrays.mass_damping + i));
    lost = hn::Div(hn::Add(half, half), hn::Add(one, half));
    scale = hn::Div(hn::Set(d, step.scale), hn::Add(one, half));
  }
  T* const fastest_of = speed + i % linear::kBlockLanes;
  V fastest = hn::Load(d, fastest_of);
  std::array<hn::Vec<decltype(dp)>, 3> x;
  for (std::size_t c = 0; c < 3; ++c) {
    const V mobility = hn::Load(d, arrays.mobility[c] + i);
    const V before = hn::Load(d, arrays.v[c] + i);
    const V change =
        hn::Sub(hn::Add(hn::Mul(hn::Mul(scale, mobility), forces[c]), hn::Mul(scale, hn::Set(d, step.gravity[c]))),
                hn::Mul(lost, before));
    const V v = kicked(d, before, hn::IfThenElse(hn::Eq(mobility, hn::Zero(d)), hn::Zero(d), change),
                       std::is_same_v<T, float> ? arrays.v_remainder[c] + i : nullptr);
    fastest = hn::Max(fastest, hn::Abs(v));
    hn::Store(v, d, arrays.v[c] + i);
    x[c] = drifted(d, hn::Load(dp, arrays.x[c] + i), hn::Mul(hn::Set(d, step.drift), v),
                   std::is_same_v<T, float> ? arrays.remainder[c] + i : nullptr);
    hn::Store(x[c], dp, arrays.x[c] + i);
  }
  hn::Store(fastest, d, fastest_of);
  if (arrays.num_corners[i / linear::kBlockLanes] == 0) return;
  hn::StoreInterleaved4(x[0], x[1], x[2], hn::Zero(dp), dp, arrays.corner_x + 4 * i);
}

template <typename T>
HWY_INLINE bool has_cluster(const LeapfrogArrays<T>& arrays, std::size_t block) {
  return arrays.has_cluster != nullptr && arrays.has_cluster[block] != 0;
}

// Moves blocks of vertices. Blocks with clusters only store their forces.
template <typename T>
HWY_NOINLINE void move(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step, bool gathered, std::size_t first,
                       std::size_t last, T* speed) {
  const LanesOf<T> d;
  for (std::size_t i = first * linear::kBlockLanes; i < last * linear::kBlockLanes; i += hn::Lanes(d)) {
    const std::size_t block = i / linear::kBlockLanes;
    const auto forces = forces_at(d, arrays, gathered || arrays.num_corners[block] > 0, i);
    if (has_cluster(arrays, block)) {
      hn::StoreInterleaved4(forces[0], forces[1], forces[2], hn::Zero(d), d, arrays.gathered + 4 * i);
    } else {
      move_at(d, arrays, step, i, forces, speed);
    }
  }
}

template <typename T>
HWY_INLINE void move_blocks_with_clusters(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step, T* speed) {
  const LanesOf<T> d;
  for (std::size_t i = 0; i < arrays.num_blocks * linear::kBlockLanes; i += hn::Lanes(d)) {
    if (!has_cluster(arrays, i / linear::kBlockLanes)) continue;
    std::array<hn::Vec<LanesOf<T>>, 4> forces;
    hn::LoadInterleaved4(d, arrays.gathered + 4 * i, forces[0], forces[1], forces[2], forces[3]);
    move_at(d, arrays, step, i, {forces[0], forces[1], forces[2]}, speed);
  }
}

// Makes a substep. Quads are stored at their lowest vertex. Once the quad forces of a block are computed, no later quad
// reads its vertices, so they can be moved.
template <MembraneLaw kLaw, typename T>
void substep(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step, T* speed) {
  irregular_forces<kLaw>(arrays, step);
  for (std::size_t i = 0; i < arrays.fine_places.size(); ++i) {
    std::memcpy(arrays.corner_force + arrays.fine_places[i], arrays.fine_force + 4 * i, 4 * sizeof(T));
  }
  if (arrays.bending != nullptr) set_bending_positions(arrays, step);
  const bool gather_all = arrays.bending != nullptr || arrays.extra_force != nullptr;
  for (std::size_t b = 0; b < arrays.num_blocks; ++b) {
    if (gather_all || arrays.num_corners[b] > 0) gather(arrays, step, b);
  }
  const bool has_quads = arrays.quads_before != nullptr;
  for (std::ptrdiff_t b = -arrays.quad_reach; b < 0; ++b) clear_quad_forces(arrays, b);
  for (std::size_t first = 0; first < arrays.num_blocks + kQuadBlocksAhead; first += kQuadBlocksAhead) {
    const std::size_t last = HWY_MIN(first + kQuadBlocksAhead, arrays.num_blocks);
    if (has_quads && first < last) quad_forces<kLaw>(arrays, step, first, last);
    if (first > 0) move(arrays, step, gather_all, first - kQuadBlocksAhead, HWY_MIN(first, arrays.num_blocks), speed);
  }
}

// Returns the larger of `largest` and the principal strains. Lanes without material have strains of -1.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V larger_strain(D d, const StrainLanes<hn::TFromD<D>>& strains, V largest) {
  const V half = hn::Set(d, hn::TFromD<D>{0.5});
  for (std::size_t l = 0; l < linear::kBlockLanes; l += hn::Lanes(d)) {
    const V e1 = hn::Load(d, &strains[0].lane[l]);
    const V e2 = hn::Load(d, &strains[1].lane[l]);
    const V shear = hn::Mul(half, hn::Load(d, &strains[2].lane[l]));
    const V difference = hn::Mul(half, hn::Sub(e1, e2));
    const V radius = hn::Sqrt(combine(difference, difference, shear, shear));
    largest = hn::Max(largest, hn::Add(hn::Mul(half, hn::Add(e1, e2)), radius));
  }
  return largest;
}

template <MembraneLaw kLaw, class D, class V = hn::Vec<D>>
V irregular_start(D d, const LeapfrogArrays<hn::TFromD<D>>& arrays, const LeapfrogStep<hn::TFromD<D>>& step,
                  V largest) {
  irregular_forces<kLaw>(arrays, step);
  for (const IrregularBlock<hn::TFromD<D>>& block : arrays.irregular) {
    if (kLaw == MembraneLaw::kCorotational) largest = larger_strain(d, block.before, largest);
  }
  return largest;
}

template <MembraneLaw kLaw, typename T>
T start(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step) {
  constexpr bool kHasStrains = kLaw == MembraneLaw::kCorotational;
  const LanesOf<T> d;
  auto largest = hn::Zero(d);
  largest = irregular_start<kLaw>(d, arrays, step, largest);
  for (std::size_t b = 0; b < arrays.num_blocks; ++b) {
    if (arrays.num_quads[b] == 0) continue;
    quad_forces<kLaw>(arrays, step, b, b + 1);
    for (std::size_t k = 0; kHasStrains && k < 2; ++k) {
      largest = larger_strain(d, arrays.quads_before[2 * b + k], largest);
    }
  }
  return hn::GetLane(hn::MaxOfLanes(d, largest));
}

template <typename T>
void substep_any(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step, T* speed) {
  step.membrane_law == MembraneLaw::kGreen ? substep<MembraneLaw::kGreen>(arrays, step, speed)
                                           : substep<MembraneLaw::kCorotational>(arrays, step, speed);
}
template <typename T>
T start_any(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step) {
  return step.membrane_law == MembraneLaw::kGreen ? start<MembraneLaw::kGreen>(arrays, step)
                                                  : start<MembraneLaw::kCorotational>(arrays, step);
}

void substep_float(const LeapfrogArrays<float>& arrays, const LeapfrogStep<float>& step, float* speed) {
  substep_any(arrays, step, speed);
}
void substep_double(const LeapfrogArrays<double>& arrays, const LeapfrogStep<double>& step, double* speed) {
  substep_any(arrays, step, speed);
}
void clusters_float(const LeapfrogArrays<float>& arrays, const LeapfrogStep<float>& step, float* speed) {
  move_blocks_with_clusters(arrays, step, speed);
}
void clusters_double(const LeapfrogArrays<double>& arrays, const LeapfrogStep<double>& step, double* speed) {
  move_blocks_with_clusters(arrays, step, speed);
}
double irregular_double(const LeapfrogArrays<double>& arrays, const LeapfrogStep<double>& step) {
  const LanesOf<double> d;
  const auto largest = step.membrane_law == MembraneLaw::kGreen
                           ? irregular_start<MembraneLaw::kGreen>(d, arrays, step, hn::Zero(d))
                           : irregular_start<MembraneLaw::kCorotational>(d, arrays, step, hn::Zero(d));
  return hn::GetLane(hn::MaxOfLanes(d, largest));
}
float start_float(const LeapfrogArrays<float>& arrays, const LeapfrogStep<float>& step) {
  return start_any(arrays, step);
}
double start_double(const LeapfrogArrays<double>& arrays, const LeapfrogStep<double>& step) {
  return start_any(arrays, step);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::fem
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::fem {
namespace {
HWY_EXPORT(substep_float);
HWY_EXPORT(substep_double);
HWY_EXPORT(clusters_float);
HWY_EXPORT(clusters_double);
HWY_EXPORT(irregular_double);
HWY_EXPORT(start_float);
HWY_EXPORT(start_double);
}  // namespace

template <>
void leapfrog_substep(const LeapfrogArrays<float>& arrays, const LeapfrogStep<float>& step, float* speed) {
  HWY_DYNAMIC_DISPATCH(substep_float)(arrays, step, speed);
}
template <>
void leapfrog_substep(const LeapfrogArrays<double>& arrays, const LeapfrogStep<double>& step, double* speed) {
  HWY_DYNAMIC_DISPATCH(substep_double)(arrays, step, speed);
}
template <>
void leapfrog_move_clusters(const LeapfrogArrays<float>& arrays, const LeapfrogStep<float>& step, float* speed) {
  HWY_DYNAMIC_DISPATCH(clusters_float)(arrays, step, speed);
}
template <>
void leapfrog_move_clusters(const LeapfrogArrays<double>& arrays, const LeapfrogStep<double>& step, double* speed) {
  HWY_DYNAMIC_DISPATCH(clusters_double)(arrays, step, speed);
}
double leapfrog_irregular(const LeapfrogArrays<double>& arrays, const LeapfrogStep<double>& step) {
  return HWY_DYNAMIC_DISPATCH(irregular_double)(arrays, step);
}
template <>
float leapfrog_start(const LeapfrogArrays<float>& arrays, const LeapfrogStep<float>& step) {
  return HWY_DYNAMIC_DISPATCH(start_float)(arrays, step);
}
template <>
double leapfrog_start(const LeapfrogArrays<double>& arrays, const LeapfrogStep<double>& step) {
  return HWY_DYNAMIC_DISPATCH(start_double)(arrays, step);
}
}  // namespace kerf::fem
#endif  // HWY_ONCE
