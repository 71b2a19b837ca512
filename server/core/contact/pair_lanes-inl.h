// Pairs of features in vector code. Included once an instruction set.
#if defined(KERF_CONTACT_PAIR_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KERF_CONTACT_PAIR_LANES_INL_H
#undef KERF_CONTACT_PAIR_LANES_INL_H
#else
#define KERF_CONTACT_PAIR_LANES_INL_H
#endif

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <hwy/highway.h>

#include "server/core/contact/feature_pair.h"

HWY_BEFORE_NAMESPACE();
namespace kerf::contact {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
using DI = hn::RebindToSigned<D>;

struct Vec3 {
  V x, y, z;
};
HWY_INLINE Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vec3 plus(const Vec3& a, const Vec3& b, V factor) {
  return {hn::Add(a.x, hn::Mul(b.x, factor)), hn::Add(a.y, hn::Mul(b.y, factor)), hn::Add(a.z, hn::Mul(b.z, factor))};
}
HWY_INLINE V dot(const Vec3& a, const Vec3& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE V clamped(V value) {
  return hn::Min(hn::Max(value, hn::Zero(D())), hn::Set(D(), 1.0F));
}
HWY_INLINE Vec3 gather(const std::array<std::vector<float>, 3>& from, hn::Vec<DI> index) {
  const D d;
  return {hn::GatherIndex(d, from[0].data(), index), hn::GatherIndex(d, from[1].data(), index),
          hn::GatherIndex(d, from[2].data(), index)};
}

// Calls append(l) for each lane l < count that is set.
template <typename M, typename Append>
HWY_INLINE void for_set_lanes(M mask, std::size_t count, const Append& append) {
  std::array<std::uint8_t, 8> bytes{};
  hn::StoreMaskBits(D(), mask, bytes.data());
  std::uint32_t bits = bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8;
  if (count < 16) bits &= (1U << count) - 1U;
  for (; bits != 0; bits &= bits - 1) append(std::countr_zero(bits));
}

// The nearest points of both sides of pairs: a of corner 0 and of a triangle, or of two edges.
struct Nearest {
  Vec3 way;          // m, from side b to side a
  V square;          // m^2, of the way
  V s, t;            // -, shares of triangle edges 1-2 and 1-3, or places on both edges
  hn::Mask<D> ends;  // of edges: the nearest points are not inside both
};

HWY_INLINE Nearest nearest_of_triangle(const std::array<Vec3, 4>& x) {
  const D d;
  const V one = hn::Set(d, 1.0F), tiny = hn::Set(d, 1e-20F);
  const Vec3 ab = x[2] - x[1], ac = x[3] - x[1], ap = x[0] - x[1];
  const V d00 = dot(ab, ab), d01 = dot(ab, ac), d11 = dot(ac, ac), d20 = dot(ap, ab), d21 = dot(ap, ac);
  const auto with = [&](V s, V t) {
    const Vec3 way = plus(plus(ap, ab, hn::Neg(s)), ac, hn::Neg(t));
    return Nearest{way, dot(way, way), s, t, hn::Lt(one, one)};
  };
  const auto nearer = [](const Nearest& a, const Nearest& b) {
    const auto is_b = hn::Lt(b.square, a.square);
    const auto of = [&](V if_b, V if_a) { return hn::IfThenElse(is_b, if_b, if_a); };
    return Nearest{{of(b.way.x, a.way.x), of(b.way.y, a.way.y), of(b.way.z, a.way.z)},
                   of(b.square, a.square),
                   of(b.s, a.s),
                   of(b.t, a.t),
                   a.ends};
  };
  Nearest edges = with(clamped(hn::Div(d20, hn::Max(d00, tiny))), hn::Zero(d));
  edges = nearer(edges, with(hn::Zero(d), clamped(hn::Div(d21, hn::Max(d11, tiny)))));
  const Vec3 bc = x[3] - x[2], bp = x[0] - x[2];
  const V on_bc = clamped(hn::Div(dot(bp, bc), hn::Max(dot(bc, bc), tiny)));
  edges = nearer(edges, with(hn::Sub(one, on_bc), on_bc));
  const V inverse = hn::Div(one, hn::Sub(hn::Mul(d00, d11), hn::Mul(d01, d01)));
  const V s = hn::Mul(hn::Sub(hn::Mul(d11, d20), hn::Mul(d01, d21)), inverse);
  const V t = hn::Mul(hn::Sub(hn::Mul(d00, d21), hn::Mul(d01, d20)), inverse);
  const auto is_over = hn::And(hn::And(hn::Ge(s, hn::Zero(d)), hn::Ge(t, hn::Zero(d))), hn::Le(hn::Add(s, t), one));
  Nearest over = with(s, t);
  over.square = hn::IfThenElse(is_over, over.square, edges.square);
  return nearer(edges, over);
}

HWY_INLINE Nearest nearest_of_edges(const std::array<Vec3, 4>& x) {
  const D d;
  const V tiny = hn::Set(d, 1e-20F), one = hn::Set(d, 1.0F);
  const Vec3 d1 = x[1] - x[0], d2 = x[3] - x[2], r = x[0] - x[2];
  const V a = hn::Max(dot(d1, d1), tiny), e = hn::Max(dot(d2, d2), tiny), f = dot(d2, r), c = dot(d1, r),
          b = dot(d1, d2);
  const V ae = hn::Mul(a, e);
  const V below = hn::Max(hn::Sub(ae, hn::Mul(b, b)), hn::Mul(hn::Set(d, 1e-6F), ae));
  V s = clamped(hn::Div(hn::Sub(hn::Mul(b, f), hn::Mul(c, e)), below));
  const V t = clamped(hn::Div(hn::Add(hn::Mul(b, s), f), e));
  s = clamped(hn::Div(hn::Sub(hn::Mul(b, t), c), a));
  const Vec3 way = plus(plus(r, d1, s), d2, hn::Neg(t));
  const auto is_inside =
      hn::And(hn::And(hn::Gt(s, hn::Zero(d)), hn::Lt(s, one)), hn::And(hn::Gt(t, hn::Zero(d)), hn::Lt(t, one)));
  return {way, dot(way, way), s, t, hn::Not(is_inside)};
}

template <FeaturePair::Kind kKind>
HWY_INLINE Nearest nearest_of(const std::array<Vec3, 4>& x) {
  return kKind == FeaturePair::Kind::kVertexTriangle ? nearest_of_triangle(x) : nearest_of_edges(x);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::contact
HWY_AFTER_NAMESPACE();

#endif  // KERF_CONTACT_PAIR_LANES_INL_H
