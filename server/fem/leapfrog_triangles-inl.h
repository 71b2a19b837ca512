// Forces of the triangles of leapfrog_kernels.cc, compiled once for each instruction set.
#if defined(KERF_FEM_LEAPFROG_TRIANGLES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KERF_FEM_LEAPFROG_TRIANGLES_INL_H
#undef KERF_FEM_LEAPFROG_TRIANGLES_INL_H
#else
#define KERF_FEM_LEAPFROG_TRIANGLES_INL_H
#endif

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <hwy/highway.h>

#include "server/fem/leapfrog_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace kerf::fem {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// A triangle thinner than this ratio of det S to tr S^2 has the stress of one as thin as this.
template <typename T>
constexpr T kLeastFlatness = std::is_same_v<T, float> ? T{1e-4} : T{1e-12};
template <typename T>
constexpr T kTiny = std::is_same_v<T, float> ? T{1e-15} : T{1e-100};

template <typename T>
using LanesOf = hn::CappedTag<T, kBlockLanes>;

template <class V>
struct Vec3 {
  V x, y, z;
};

template <class V>
HWY_INLINE Vec3<V> plus(const Vec3<V>& a, const Vec3<V>& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
template <class V>
HWY_INLINE Vec3<V> minus(const Vec3<V>& a, const Vec3<V>& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
// a s + b t
template <class V>
HWY_INLINE V combine(V a, V s, V b, V t) {
  return hn::Add(hn::Mul(a, s), hn::Mul(b, t));
}
template <class V>
HWY_INLINE Vec3<V> combine(const Vec3<V>& a, V s, const Vec3<V>& b, V t) {
  return {combine(a.x, s, b.x, t), combine(a.y, s, b.y, t), combine(a.z, s, b.z, t)};
}
template <class V>
HWY_INLINE V dot(const Vec3<V>& a, const Vec3<V>& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}

// A difference of positions, in their unit and in m.
template <class D>
HWY_INLINE hn::Vec<D> converted(D d, hn::Vec<hn::Rebind<std::int32_t, D>> difference) {
  return hn::ConvertTo(d, difference);
}
template <class D>
HWY_INLINE hn::Vec<D> converted(D /*d*/, hn::Vec<D> difference) {
  return difference;
}
template <class D, class P>
HWY_INLINE hn::Vec<D> length(D d, P difference, hn::Vec<D> unit) {
  return std::is_same_v<hn::TFromD<D>, float> ? hn::Mul(converted(d, difference), unit) : converted(d, difference);
}
template <class D, class P>
HWY_INLINE Vec3<hn::Vec<D>> edge(D d, const Vec3<P>& to, const Vec3<P>& from, hn::Vec<D> unit) {
  return {length(d, hn::Sub(to.x, from.x), unit), length(d, hn::Sub(to.y, from.y), unit),
          length(d, hn::Sub(to.z, from.z), unit)};
}

// Membrane law, N/m, and damping, -: see LawLanes.
template <class V>
struct Law {
  V C11, C22, C33, C12, damping;
};
template <class D>
HWY_INLINE Law<hn::Vec<D>> common_law(D d, const LeapfrogStep<hn::TFromD<D>>& step) {
  return {hn::Set(d, step.law[0]), hn::Set(d, step.law[1]), hn::Set(d, step.law[2]), hn::Set(d, step.law[3]),
          hn::Set(d, step.damping)};
}
template <class D>
HWY_INLINE Law<hn::Vec<D>> law_of(D d, const LawLanes<hn::TFromD<D>>& lanes, std::size_t l) {
  const auto load = [&](std::size_t k) HWY_ATTR { return hn::Load(d, &lanes.value[k].lane[l]); };
  return {load(0), load(1), load(2), load(3), load(4)};
}

template <class D>
HWY_INLINE hn::Vec<D> damping_of(D d, const LawLanes<hn::TFromD<D>>& lanes, std::size_t l) {
  return hn::Load(d, &lanes.value[4].lane[l]);
}

// Triangles with edges d1, d2 from corner 0; formulas in membrane.h, with R = F S^-1 and c = F^T F, det S = d,
// tr S = s, S = (c + d I) / s.
template <class V>
struct Triangles {
  Vec3<V> f1, f2;  // columns of F
  V g1x, g1y, g2x, g2y;
  V c11, c22, c12, trace;
  V det, s, both;  // both: 1 / (s det)
  Vec3<V> force1, force2;
};

template <class D, class V = hn::Vec<D>>
HWY_INLINE void set_metric(D d, const TriangleLanes<hn::TFromD<D>>& lanes, std::size_t l, const Vec3<V>& d1,
                           const Vec3<V>& d2, Triangles<V>& t) {
  t.g1x = hn::Load(d, &lanes.g1[0].lane[l]);
  t.g1y = hn::Load(d, &lanes.g1[1].lane[l]);
  t.g2x = hn::Load(d, &lanes.g2[0].lane[l]);
  t.g2y = hn::Load(d, &lanes.g2[1].lane[l]);
  t.f1 = combine(d1, t.g1x, d2, t.g2x);
  t.f2 = combine(d1, t.g1y, d2, t.g2y);
  t.c11 = dot(t.f1, t.f1);
  t.c22 = dot(t.f2, t.f2);
  t.c12 = dot(t.f1, t.f2);
  t.trace = hn::Add(t.c11, t.c22);
  const Vec3<V> normal{hn::Sub(hn::Mul(t.f1.y, t.f2.z), hn::Mul(t.f1.z, t.f2.y)),
                       hn::Sub(hn::Mul(t.f1.z, t.f2.x), hn::Mul(t.f1.x, t.f2.z)),
                       hn::Sub(hn::Mul(t.f1.x, t.f2.y), hn::Mul(t.f1.y, t.f2.x))};
  t.det = dot(normal, normal);  // squared
}

template <class D, class V = hn::Vec<D>>
HWY_INLINE void set_det(D d, Triangles<V>& t) {
  using T = hn::TFromD<D>;
  const V least = hn::Add(hn::Mul(t.trace, hn::Set(d, kLeastFlatness<T>)), hn::Set(d, kTiny<T>));
  t.det = hn::Max(hn::Sqrt(t.det), least);
}

template <class D, class V = hn::Vec<D>>
HWY_INLINE void set_inverses(D d, Triangles<V>& t) {
  t.s = hn::Sqrt(hn::Add(t.trace, hn::Add(t.det, t.det)));
  t.both = hn::Div(hn::Set(d, hn::TFromD<D>{1}), hn::Mul(t.s, t.det));
}

// What of a strain of the substep before is to be added to that of now for damping: beta times the rate of strain
// between them, which is when velocities are. Keeps the strain for the next.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V damped(D d, V damping, V strain, hn::TFromD<D>* before) {
  const V change = hn::Sub(strain, hn::Load(d, before));
  hn::Store(strain, d, before);
  return hn::Add(strain, hn::Mul(damping, change));
}

// Forces on corners 1 and 2. The differences in e = S - I = (c + (d - s) I) / s are exact where strains are small.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void set_forces(D d, const Law<V>& law, const TriangleLanes<hn::TFromD<D>>& lanes, std::size_t l,
                           StrainLanes<hn::TFromD<D>>& before, Triangles<V>& t) {
  const V inverse_s = hn::Mul(t.both, t.det);
  const V inverse_det = hn::Mul(t.both, t.s);
  const V shift = hn::Sub(t.det, t.s);
  const V S11 = hn::Mul(hn::Add(t.c11, t.det), inverse_s);
  const V S22 = hn::Mul(hn::Add(t.c22, t.det), inverse_s);
  const V S12 = hn::Mul(t.c12, inverse_s);
  const V slant = hn::Neg(hn::Mul(S12, inverse_det));
  const Vec3<V> R1 = combine(t.f1, hn::Mul(S22, inverse_det), t.f2, slant);
  const Vec3<V> R2 = combine(t.f1, slant, t.f2, hn::Mul(S11, inverse_det));

  const V e1 = damped(d, law.damping, hn::Mul(hn::Add(t.c11, shift), inverse_s), &before[0].lane[l]);
  const V e2 = damped(d, law.damping, hn::Mul(hn::Add(t.c22, shift), inverse_s), &before[1].lane[l]);
  const V e3 = damped(d, law.damping, hn::Add(S12, S12), &before[2].lane[l]);
  const V sigma1 = combine(law.C11, e1, law.C12, e2);
  const V sigma2 = combine(law.C12, e1, law.C22, e2);
  const V sigma3 = hn::Mul(law.C33, e3);
  const V a = hn::Mul(combine(S12, hn::Sub(sigma1, sigma2), sigma3, hn::Sub(S22, S11)), inverse_s);
  const V minus_area = hn::Load(d, &lanes.minus_area.lane[l]);
  // The forces R T g, by way of two components a corner.
  const V T11 = hn::Mul(minus_area, sigma1);
  const V T12 = hn::Mul(minus_area, hn::Sub(sigma3, a));
  const V T21 = hn::Mul(minus_area, hn::Add(sigma3, a));
  const V T22 = hn::Mul(minus_area, sigma2);
  t.force1 = combine(R1, combine(T11, t.g1x, T12, t.g1y), R2, combine(T21, t.g1x, T22, t.g1y));
  t.force2 = combine(R1, combine(T11, t.g2x, T12, t.g2y), R2, combine(T21, t.g2x, T22, t.g2y));
}

// Of two vectors of triangles side by side: one waits for its square roots while the other computes.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void corner_forces(D d, const Law<V>& law0, const Law<V>& law1,
                              std::array<const TriangleLanes<hn::TFromD<D>>*, 2> lanes, std::size_t l,
                              std::array<StrainLanes<hn::TFromD<D>>*, 2> before, std::array<Triangles<V>, 2>& t) {
  set_det(d, t[0]);
  set_det(d, t[1]);
  set_inverses(d, t[0]);
  set_inverses(d, t[1]);
  set_forces(d, law0, *lanes[0], l, *before[0], t[0]);
  set_forces(d, law1, *lanes[1], l, *before[1], t[1]);
}

// Of triangles with Green's strain; see EdgeLanes.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void set_edge_forces(D d, V damping, const EdgeLanes<hn::TFromD<D>>& lanes, std::size_t l, const Vec3<V>& d1,
                                const Vec3<V>& d2, StrainLanes<hn::TFromD<D>>& before, Triangles<V>& t) {
  const auto strain = [&](std::size_t k, const Vec3<V>& side) HWY_ATTR {
    const V excess = hn::Sub(dot(side, side), hn::Load(d, &lanes.length_squared[k].lane[l]));
    return damped(d, damping, excess, &before[k].lane[l]);
  };
  const auto H = [&](std::size_t k) HWY_ATTR { return hn::Load(d, &lanes.stiffness[k].lane[l]); };
  const Vec3<V> d3 = minus(d2, d1);
  const V s1 = strain(0, d1);
  const V s2 = strain(1, d2);
  const V s3 = strain(2, d3);
  const V H12 = H(3);
  const V H13 = H(4);
  const V H23 = H(5);
  const V t1 = hn::Add(combine(H(0), s1, H12, s2), hn::Mul(H13, s3));
  const V t2 = hn::Add(combine(H12, s1, H(1), s2), hn::Mul(H23, s3));
  const V t3 = hn::Add(combine(H13, s1, H23, s2), hn::Mul(H(2), s3));
  t.force1 = combine(d3, t3, d1, hn::Neg(t1));
  t.force2 = combine(d3, hn::Neg(t3), d2, hn::Neg(t2));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::fem
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
