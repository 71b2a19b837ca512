#include "server/core/contact/lane_contact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/contact/lane_contact.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf::contact {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, mesh::kVertexLanes>;
using V = hn::Vec<D>;

struct Vec3 {
  V x, y, z;
};

HWY_INLINE V set(double value) {
  return hn::Set(D(), value);
}
HWY_INLINE Vec3 set(const Eigen::Vector3d& value) {
  return {set(value.x()), set(value.y()), set(value.z())};
}
HWY_INLINE Vec3 load(const std::array<mesh::VertexLanes::Lanes, 3>& from, std::size_t l) {
  const D d;
  return {hn::Load(d, &from[0][l]), hn::Load(d, &from[1][l]), hn::Load(d, &from[2][l])};
}
HWY_INLINE void store(const Vec3& value, std::array<mesh::VertexLanes::Lanes, 3>& to, std::size_t l) {
  const D d;
  hn::Store(value.x, d, &to[0][l]);
  hn::Store(value.y, d, &to[1][l]);
  hn::Store(value.z, d, &to[2][l]);
}
HWY_INLINE Vec3 minus(const Vec3& a, const Vec3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE V dot(const Vec3& a, const Vec3& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE Vec3 times(const Vec3& a, V s) {
  return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)};
}
// Returns a + s b.
HWY_INLINE Vec3 plus(const Vec3& a, const Vec3& b, V s) {
  return {hn::Add(a.x, hn::Mul(b.x, s)), hn::Add(a.y, hn::Mul(b.y, s)), hn::Add(a.z, hn::Mul(b.z, s))};
}
HWY_INLINE Vec3 choose(hn::Mask<D> mask, const Vec3& yes, const Vec3& no) {
  return {hn::IfThenElse(mask, yes.x, no.x), hn::IfThenElse(mask, yes.y, no.y), hn::IfThenElse(mask, yes.z, no.z)};
}

constexpr double kTinySquare = 1e-30;  // m^2; a vector with a smaller square has no direction

// Returns 1 / sqrt(q), accurate to 1e-7, for q >= kTinySquare. Root and quotient of floats take a third of the time of
// those of doubles.
HWY_INLINE V coarse_inverse_root(V q) {
  const hn::Rebind<float, D> narrow;
  return hn::PromoteTo(D(), hn::Div(hn::Set(narrow, 1.0F), hn::Sqrt(hn::DemoteTo(narrow, q))));
}
// Returns 1 / sqrt(q), accurate to 1e-14, with one Newton step.
HWY_INLINE V inverse_root(V q) {
  const V r = coarse_inverse_root(q);
  return hn::Mul(r, hn::Sub(set(1.5), hn::Mul(hn::Mul(set(0.5), q), hn::Mul(r, r))));
}

struct Near {
  V distance;   // m
  Vec3 normal;  // -
};

// Returns the distance and normal of points at `offset` from the axis or centre of a round body.
HWY_INLINE Near round(const Vec3& offset, double radius, const Eigen::Vector3d& fallback) {
  const V square = dot(offset, offset);
  const auto has_direction = hn::Ge(square, set(kTinySquare));
  const V inverse = inverse_root(hn::Max(square, set(kTinySquare)));
  const V length = hn::IfThenElseZero(has_direction, hn::Mul(square, inverse));
  return {hn::Sub(length, set(radius)), choose(has_direction, times(offset, inverse), set(fallback))};
}

HWY_INLINE Near near_plane(const PreparedCollider& plane, const Vec3& x) {
  const Vec3 normal = set(plane.vector());
  return {dot(minus(x, set(plane.origin())), normal), normal};
}

HWY_INLINE Near near_sphere(const PreparedCollider& sphere, const Vec3& x) {
  return round(minus(x, set(sphere.origin())), sphere.radius(), Eigen::Vector3d::UnitZ());
}

HWY_INLINE Near near_capsule(const PreparedCollider& capsule, const Vec3& x) {
  const Vec3 from_a = minus(x, set(capsule.origin()));
  const double length_squared = capsule.vector().squaredNorm();
  if (length_squared == 0.0) return round(from_a, capsule.radius(), Eigen::Vector3d::UnitZ());
  const Vec3 axis = set(capsule.vector());
  const V along = hn::Div(dot(from_a, axis), set(length_squared));
  const V t = hn::Min(hn::Max(along, set(0.0)), set(1.0));
  return round(plus(from_a, axis, hn::Neg(t)), capsule.radius(), capsule.across());
}

HWY_INLINE Near near_box(const PreparedCollider& box, const Vec3& x) {
  const D d;
  const Vec3 offset = minus(x, set(box.origin()));
  const std::array<Vec3, 3> axes{set(box.rotation().col(0)), set(box.rotation().col(1)), set(box.rotation().col(2))};
  std::array<V, 3> sign{set(1.0), set(1.0), set(1.0)};
  std::array<V, 3> excess{set(0.0), set(0.0), set(0.0)};  // m, distance outside the box along each axis; below 0 inside
  for (std::size_t k = 0; k < 3; ++k) {
    const V local = dot(offset, axes[k]);
    sign[k] = hn::IfThenElse(hn::Lt(local, set(0.0)), set(-1.0), set(1.0));
    excess[k] = hn::Sub(hn::Abs(local), set(box.vector()[static_cast<Eigen::Index>(k)]));
  }
  // Finds the nearest face of the box; the first wins among equals.
  V largest = excess[0];
  Vec3 face = times(axes[0], sign[0]);
  for (std::size_t k = 1; k < 3; ++k) {
    const auto is_nearer = hn::Gt(excess[k], largest);
    largest = hn::IfThenElse(is_nearer, excess[k], largest);
    face = choose(is_nearer, times(axes[k], sign[k]), face);
  }
  Vec3 outward{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  for (std::size_t k = 0; k < 3; ++k) {
    outward = plus(outward, axes[k], hn::Mul(sign[k], hn::Max(excess[k], hn::Zero(d))));
  }
  const V square = dot(outward, outward);
  const auto is_outside = hn::Ge(square, set(kTinySquare));
  const V inverse = inverse_root(hn::Max(square, set(kTinySquare)));
  return {hn::IfThenElse(is_outside, hn::Mul(square, inverse), largest),
          choose(is_outside, times(outward, inverse), face)};
}

constexpr bool is_round(PreparedCollider::Kind kind) {
  return kind == PreparedCollider::Kind::kSphere || kind == PreparedCollider::Kind::kCapsule;
}

template <PreparedCollider::Kind kKind>
HWY_INLINE Near near_one(const PreparedCollider& collider, const Vec3& x) {
  switch (kKind) {
    case PreparedCollider::Kind::kPlane:
      return near_plane(collider, x);
    case PreparedCollider::Kind::kSphere:
      return near_sphere(collider, x);
    case PreparedCollider::Kind::kBox:
      return near_box(collider, x);
    case PreparedCollider::Kind::kCapsule:
      return near_capsule(collider, x);
  }
}

// Returns the fraction (-, in [0, 1]) that is left of a tangential vector when friction shortens it by `limit`.
HWY_INLINE V share_left(const Vec3& tangential, V limit) {
  const V square = hn::Max(dot(tangential, tangential), set(kTinySquare));
  return hn::Max(hn::Sub(set(1.0), hn::Mul(limit, coarse_inverse_root(square))), set(0.0));
}

template <PreparedCollider::Kind kKind>
HWY_NOINLINE void gaps_of(const PreparedCollider& collider, const ThicknessLanes& thickness,
                          const mesh::VertexLanes& vertices, mesh::VertexLanes::Lanes& gaps) {
  const D d;
  for (std::size_t l = 0; l < mesh::kVertexLanes; l += hn::Lanes(d)) {
    const Near near = near_one<kKind>(collider, load(vertices.x, l));
    hn::StoreU(hn::Sub(near.distance, hn::LoadU(d, &thickness[l])), d, &gaps[l]);
  }
}

template <PreparedCollider::Kind kKind>
HWY_NOINLINE LanePush push_of(const PreparedCollider& collider, const ThicknessLanes& thickness,
                              mesh::VertexLanes& vertices) {
  const D d;
  LanePush result;
  V least_gap = set(std::numeric_limits<double>::infinity());
  V deepest = hn::Zero(d);
  V most_lost = hn::Zero(d);  // m^2, largest square of a tangential displacement that friction took away
  const double friction = collider.friction();
  for (std::size_t l = 0; l < mesh::kVertexLanes; l += hn::Lanes(d)) {
    Vec3 x = load(vertices.x, l);
    const Near near = near_one<kKind>(collider, x);
    const V gap = hn::Sub(near.distance, hn::LoadU(d, &thickness[l]));
    const auto is_inside = hn::Lt(gap, hn::Zero(d));
    least_gap = hn::Min(least_gap, hn::Max(gap, hn::Zero(d)));
    if (hn::AllFalse(d, is_inside)) continue;
    const V depth = hn::IfThenElseZero(is_inside, hn::Neg(gap));
    deepest = hn::Max(deepest, depth);
    const Vec3& n = near.normal;
    const Vec3 v = load(vertices.v, l);
    const V approach = hn::Min(dot(v, n), hn::Zero(d));  // m/s
    Vec3 v_after = plus(v, n, hn::Neg(approach));
    Vec3 x_after = plus(x, n, depth);
    if (friction > 0.0) {
      const Vec3 u = minus(x, load(vertices.before, l));
      const Vec3 slid = plus(u, n, hn::Neg(dot(u, n)));
      const V lost = hn::Sub(share_left(slid, hn::Mul(set(friction), depth)), set(1.0));
      x_after = plus(x_after, slid, lost);
      const V square = hn::Mul(dot(slid, slid), hn::Mul(lost, lost));
      most_lost = hn::Max(most_lost, hn::IfThenElseZero(is_inside, square));
      // A vertex that leaves the surface is not slowed.
      const V left = share_left(v_after, hn::Mul(set(-friction), approach));
      v_after = choose(hn::Lt(approach, hn::Zero(d)), times(v_after, left), v_after);
    }
    store(choose(is_inside, x_after, x), vertices.x, l);
    store(choose(is_inside, v_after, v), vertices.v, l);
    std::array<std::uint8_t, 8> bits{};
    hn::StoreMaskBits(d, is_inside, bits.data());
    result.pushed |= static_cast<std::uint32_t>(bits[0] | bits[1] << 8) << l;
  }
  result.least_gap = hn::GetLane(hn::MinOfLanes(d, least_gap));
  result.deepest = hn::GetLane(hn::MaxOfLanes(d, deepest));
  result.farthest = (1.0 + friction) * result.deepest;
  const double square = hn::GetLane(hn::MaxOfLanes(d, most_lost));
  if (kKind == PreparedCollider::Kind::kBox) result.residual = std::sqrt(square);
  if (is_round(kKind)) result.residual = std::min(std::sqrt(square), square / collider.radius());
  return result;
}

template <typename Visit>
HWY_INLINE auto with_kind(const PreparedCollider& collider, const Visit& visit) {
  using Kind = PreparedCollider::Kind;
  switch (collider.kind()) {
    case Kind::kSphere:
      return visit(std::integral_constant<Kind, Kind::kSphere>());
    case Kind::kBox:
      return visit(std::integral_constant<Kind, Kind::kBox>());
    case Kind::kCapsule:
      return visit(std::integral_constant<Kind, Kind::kCapsule>());
    default:
      return visit(std::integral_constant<Kind, Kind::kPlane>());
  }
}

void gaps_any(const PreparedCollider& collider, const ThicknessLanes& thickness, const mesh::VertexLanes& vertices,
              mesh::VertexLanes::Lanes& gaps) {
  with_kind(collider, [&](auto kind) { gaps_of<decltype(kind)::value>(collider, thickness, vertices, gaps); });
}
LanePush push_any(const PreparedCollider& collider, const ThicknessLanes& thickness, mesh::VertexLanes& vertices) {
  return with_kind(collider, [&](auto kind) { return push_of<decltype(kind)::value>(collider, thickness, vertices); });
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::contact
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::contact {
namespace {
HWY_EXPORT(gaps_any);
HWY_EXPORT(push_any);
}  // namespace

void find_gaps(const PreparedCollider& collider, const ThicknessLanes& thickness, const mesh::VertexLanes& vertices,
               mesh::VertexLanes::Lanes& gaps) {
  HWY_DYNAMIC_DISPATCH(gaps_any)(collider, thickness, vertices, gaps);
}
LanePush push_out(const PreparedCollider& collider, const ThicknessLanes& thickness, mesh::VertexLanes& vertices) {
  return HWY_DYNAMIC_DISPATCH(push_any)(collider, thickness, vertices);
}
}  // namespace kerf::contact
#endif  // HWY_ONCE
