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

#include "server/core/fem/leapfrog/leapfrog_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace kerf::fem {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// Least det S over tr F^T F, or in steps by displacements least det S. A triangle with less is treated as if it had
// this much.
template <typename T>
constexpr T kLeastFlatness = std::is_same_v<T, float> ? T{1e-4} : T{1e-12};
template <typename T>
constexpr T kTiny = std::is_same_v<T, float> ? T{1e-15} : T{1e-100};

template <typename T>
using LanesOf = hn::CappedTag<T, linear::kBlockLanes>;

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
// Returns a s + b t.
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

// Converts a difference of positions to T, in their unit.
template <class D>
HWY_INLINE hn::Vec<D> converted(D d, hn::Vec<hn::Rebind<std::int32_t, D>> difference) {
  return hn::ConvertTo(d, difference);
}
template <class D>
HWY_INLINE hn::Vec<D> converted(D /*d*/, hn::Vec<D> difference) {
  return difference;
}
template <class D, class P>
HWY_INLINE Vec3<hn::Vec<D>> edge(D d, const Vec3<P>& to, const Vec3<P>& from) {
  return {converted(d, hn::Sub(to.x, from.x)), converted(d, hn::Sub(to.y, from.y)),
          converted(d, hn::Sub(to.z, from.z))};
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

template <typename T>
using TriangleValues = std::array<T, linear::kBlockLanes>;  // of kBlockLanes triangles; uninitialised

// Intermediate values of kBlockLanes triangles while their forces are computed. Each stage of the computation processes
// several blocks, because a block alone would wait for its own square roots. Formulas in membrane.h, with F = R S, c =
// F^T F, d = det S, s = tr S.
template <typename T>
struct alignas(64) StretchLanes {
  std::array<TriangleValues<T>, 3> f1, f2;       // columns of F
  TriangleValues<T> c11, c22, c12, det_squared;  // det S squared
  TriangleValues<T> inverse_trace, inverse_det;  // 1 / s, 1 / d

  // Results of set_strains(): the diagonal of S - I, and S12. They overwrite values that are no longer needed.
  TriangleValues<T>& strain1() { return c11; }
  TriangleValues<T>& strain2() { return c22; }
  TriangleValues<T>& S12() { return c12; }
};

template <class D>
HWY_INLINE Vec3<hn::Vec<D>> load3(D d, const std::array<TriangleValues<hn::TFromD<D>>, 3>& from, std::size_t l) {
  return {hn::Load(d, &from[0][l]), hn::Load(d, &from[1][l]), hn::Load(d, &from[2][l])};
}
template <class D>
HWY_INLINE void store3(D d, const Vec3<hn::Vec<D>>& value, std::array<TriangleValues<hn::TFromD<D>>, 3>& to,
                       std::size_t l) {
  hn::Store(value.x, d, &to[0][l]);
  hn::Store(value.y, d, &to[1][l]);
  hn::Store(value.z, d, &to[2][l]);
}

// First stage: sets F, c and det S squared of triangles with the edges d1, d2 from corner 0.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void set_gradients(D d, const TriangleLanes<hn::TFromD<D>>& lanes, std::size_t l, const Vec3<V>& d1,
                              const Vec3<V>& d2, StretchLanes<hn::TFromD<D>>& to) {
  const Vec3<V> f1 = combine(d1, hn::Load(d, &lanes.g1[0].lane[l]), d2, hn::Load(d, &lanes.g2[0].lane[l]));
  const Vec3<V> f2 = combine(d1, hn::Load(d, &lanes.g1[1].lane[l]), d2, hn::Load(d, &lanes.g2[1].lane[l]));
  const Vec3<V> normal{hn::Sub(hn::Mul(f1.y, f2.z), hn::Mul(f1.z, f2.y)),
                       hn::Sub(hn::Mul(f1.z, f2.x), hn::Mul(f1.x, f2.z)),
                       hn::Sub(hn::Mul(f1.x, f2.y), hn::Mul(f1.y, f2.x))};
  store3(d, f1, to.f1, l);
  store3(d, f2, to.f2, l);
  hn::Store(dot(f1, f1), d, &to.c11[l]);
  hn::Store(dot(f2, f2), d, &to.c22[l]);
  hn::Store(dot(f1, f2), d, &to.c12[l]);
  hn::Store(dot(normal, normal), d, &to.det_squared[l]);
}

// First stage in steps by displacements: d1, d2 are differences of displacements since the step began. Stores F^T F - I
// in place of c, and det S squared - 1 in place of det S squared. Small values are thus never differences of large
// ones.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void set_gradients(D d, const TriangleLanes<hn::TFromD<D>>& lanes, const StartLanes<hn::TFromD<D>>& start,
                              std::size_t l, const Vec3<V>& d1, const Vec3<V>& d2, StretchLanes<hn::TFromD<D>>& to) {
  const auto load = [&](const linear::Lanes16<hn::TFromD<D>>& from) HWY_ATTR { return hn::Load(d, &from.lane[l]); };
  const Vec3<V> start1{load(start.f1[0]), load(start.f1[1]), load(start.f1[2])};
  const Vec3<V> start2{load(start.f2[0]), load(start.f2[1]), load(start.f2[2])};
  const Vec3<V> change1 = combine(d1, load(lanes.g1[0]), d2, load(lanes.g2[0]));
  const Vec3<V> change2 = combine(d1, load(lanes.g1[1]), d2, load(lanes.g2[1]));
  const Vec3<V> f1 = plus(start1, change1);
  const Vec3<V> f2 = plus(start2, change2);
  const V e11 = hn::Add(load(start.e11), dot(change1, plus(start1, f1)));
  const V e22 = hn::Add(load(start.e22), dot(change2, plus(start2, f2)));
  const V e12 = hn::Add(load(start.e12), hn::Add(dot(change1, f2), dot(start1, change2)));
  store3(d, f1, to.f1, l);
  store3(d, f2, to.f2, l);
  hn::Store(e11, d, &to.c11[l]);
  hn::Store(e22, d, &to.c22[l]);
  hn::Store(e12, d, &to.c12[l]);
  const V product = hn::Sub(hn::Mul(e11, e22), hn::Mul(e12, e12));
  hn::Store(hn::Add(hn::Add(e11, e22), product), d, &to.det_squared[l]);
}

// Second stage: sets S - I, S12, 1 / s and 1 / d. The differences in S - I = (c + (d - s) I) / s are exact for small
// strains.
template <typename T>
HWY_INLINE void set_strains(StretchLanes<T>* blocks, std::size_t num_blocks) {
  const LanesOf<T> d;
  for (std::size_t b = 0; b < num_blocks; ++b) {
    StretchLanes<T>& t = blocks[b];
    for (std::size_t l = 0; l < linear::kBlockLanes; l += hn::Lanes(d)) {
      const auto c11 = hn::Load(d, &t.c11[l]);
      const auto c22 = hn::Load(d, &t.c22[l]);
      const auto trace = hn::Add(c11, c22);
      const auto least = hn::Add(hn::Mul(trace, hn::Set(d, kLeastFlatness<T>)), hn::Set(d, kTiny<T>));
      const auto det = hn::Max(hn::Sqrt(hn::Load(d, &t.det_squared[l])), least);
      const auto s = hn::Sqrt(hn::Add(trace, hn::Add(det, det)));
      const auto both = hn::Div(hn::Set(d, T{1}), hn::Mul(s, det));
      const auto inverse_s = hn::Mul(both, det);
      const auto shift = hn::Sub(det, s);
      hn::Store(hn::Mul(hn::Add(c11, shift), inverse_s), d, &t.strain1()[l]);
      hn::Store(hn::Mul(hn::Add(c22, shift), inverse_s), d, &t.strain2()[l]);
      hn::Store(hn::Mul(hn::Load(d, &t.c12[l]), inverse_s), d, &t.S12()[l]);
      hn::Store(inverse_s, d, &t.inverse_trace[l]);
      hn::Store(hn::Mul(both, s), d, &t.inverse_det[l]);
    }
  }
}

// Second stage in steps by displacements. S - I = (E + (p - q) I) / s with F^T F = I + E, d = 1 + p and s = 2 + q.
template <typename T>
HWY_INLINE void set_strains_from_start(StretchLanes<T>* blocks, std::size_t num_blocks) {
  const LanesOf<T> d;
  const auto one = hn::Set(d, T{1});
  const auto two = hn::Set(d, T{2});
  const auto least = hn::Set(d, kLeastFlatness<T> * kLeastFlatness<T>);
  for (std::size_t b = 0; b < num_blocks; ++b) {
    StretchLanes<T>& t = blocks[b];
    for (std::size_t l = 0; l < linear::kBlockLanes; l += hn::Lanes(d)) {
      const auto e11 = hn::Load(d, &t.c11[l]);
      const auto e22 = hn::Load(d, &t.c22[l]);
      const auto more_squared = hn::Load(d, &t.det_squared[l]);
      const auto det = hn::Sqrt(hn::Max(hn::Add(one, more_squared), least));
      const auto p = hn::Div(more_squared, hn::Add(one, det));
      const auto more = hn::Add(hn::Add(e11, e22), hn::Add(p, p));
      const auto s = hn::Sqrt(hn::Add(hn::Add(two, two), more));
      const auto shift = hn::Sub(p, hn::Div(more, hn::Add(two, s)));
      const auto both = hn::Div(one, hn::Mul(s, det));
      const auto inverse_s = hn::Mul(both, det);
      hn::Store(hn::Mul(hn::Add(e11, shift), inverse_s), d, &t.strain1()[l]);
      hn::Store(hn::Mul(hn::Add(e22, shift), inverse_s), d, &t.strain2()[l]);
      hn::Store(hn::Mul(hn::Load(d, &t.c12[l]), inverse_s), d, &t.S12()[l]);
      hn::Store(inverse_s, d, &t.inverse_trace[l]);
      hn::Store(hn::Mul(both, s), d, &t.inverse_det[l]);
    }
  }
}

template <class V>
struct CornerForces {
  Vec3<V> force1, force2;
};

// Returns a strain plus beta times its rate. `damping` is beta / h. The rate is the change since the previous substep,
// whose strain is in `before`, over h. It is centred at the time of the velocities. Stores the strain in `before` for
// the next substep.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V damped(D d, V damping, V strain, hn::TFromD<D>* before) {
  const V change = hn::Sub(strain, hn::Load(d, before));
  hn::Store(strain, d, before);
  return hn::Add(strain, hn::Mul(damping, change));
}

// Returns corner forces in second Piola-Kirchhoff form: R T = F N, and N = S^-1 T is symmetric for any symmetric sigma.
template <class D, class V = hn::Vec<D>>
HWY_INLINE CornerForces<V> corner_forces(D d, const Law<V>& law, const TriangleLanes<hn::TFromD<D>>& lanes,
                                         std::size_t l, StretchLanes<hn::TFromD<D>>& stretch,
                                         StrainLanes<hn::TFromD<D>>& before) {
  const V one = hn::Set(d, hn::TFromD<D>{1});
  const V strain1 = hn::Load(d, &stretch.strain1()[l]);
  const V strain2 = hn::Load(d, &stretch.strain2()[l]);
  const V S12 = hn::Load(d, &stretch.S12()[l]);
  const V S11 = hn::Add(strain1, one);
  const V S22 = hn::Add(strain2, one);
  // e1 to e3, and all that follows from them, include the factor of forces, -A / det S.
  const V factor = hn::Mul(hn::Load(d, &lanes.minus_area.lane[l]), hn::Load(d, &stretch.inverse_det[l]));
  const V e1 = hn::Mul(damped(d, law.damping, strain1, &before[0].lane[l]), factor);
  const V e2 = hn::Mul(damped(d, law.damping, strain2, &before[1].lane[l]), factor);
  const V e3 = hn::Mul(damped(d, law.damping, hn::Add(S12, S12), &before[2].lane[l]), factor);
  const V sigma1 = combine(law.C11, e1, law.C12, e2);
  const V sigma2 = combine(law.C12, e1, law.C22, e2);
  const V sigma3 = hn::Mul(law.C33, e3);
  const V a = hn::Mul(combine(S12, hn::Sub(sigma1, sigma2), sigma3, hn::Sub(strain2, strain1)),
                      hn::Load(d, &stretch.inverse_trace[l]));
  const V T12 = hn::Sub(sigma3, a);
  const V T21 = hn::Add(sigma3, a);
  const V N11 = hn::Sub(hn::Mul(S22, sigma1), hn::Mul(S12, T21));
  const V N12 = hn::Sub(hn::Mul(S22, T12), hn::Mul(S12, sigma2));
  const V N22 = hn::Sub(hn::Mul(S11, sigma2), hn::Mul(S12, T12));
  const Vec3<V> f1 = load3(d, stretch.f1, l);
  const Vec3<V> f2 = load3(d, stretch.f2, l);
  const auto force = [&](const std::array<linear::Lanes16<hn::TFromD<D>>, 2>& g) HWY_ATTR {
    const V gx = hn::Load(d, &g[0].lane[l]);
    const V gy = hn::Load(d, &g[1].lane[l]);
    return combine(f1, combine(N11, gx, N12, gy), f2, combine(N12, gx, N22, gy));
  };
  return {force(lanes.g1), force(lanes.g2)};
}

// Returns forces of triangles with Green's strain; see EdgeLanes.
template <class D, class V = hn::Vec<D>>
HWY_INLINE CornerForces<V> edge_forces(D d, V damping, const EdgeLanes<hn::TFromD<D>>& lanes, std::size_t l,
                                       const Vec3<V>& d1, const Vec3<V>& d2, StrainLanes<hn::TFromD<D>>& before) {
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
  return {combine(d3, t3, d1, hn::Neg(t1)), combine(d3, hn::Neg(t3), d2, hn::Neg(t2))};
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::fem
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
