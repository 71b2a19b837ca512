#include "server/core/contact/pair_lanes.h"

#include <algorithm>
#include <bit>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/contact/pair_lanes.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

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

// Appends first + l for each lane l that is set.
template <typename M, typename Append>
HWY_INLINE void for_set_lanes(M mask, std::size_t count, const Append& append) {
  std::array<std::uint8_t, 8> bytes{};
  hn::StoreMaskBits(D(), mask, bytes.data());
  std::uint32_t bits = bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8;
  if (count < 16) bits &= (1U << count) - 1U;
  for (; bits != 0; bits &= bits - 1) append(std::countr_zero(bits));
}

void find_overlaps_any(const BoxLanes& boxes, BoxRange range, const float* way, const BoxLanes& others,
                       BoxRange other_range, bool after, std::vector<std::array<std::int32_t, 2>>& found) {
  const D d;
  for (std::int32_t i = range.begin; i < range.end; ++i) {
    const auto at = static_cast<std::size_t>(i);
    std::array<V, 3> low, high;
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = hn::Set(d, boxes.low[k][at] + std::min(way[k], 0.0F));
      high[k] = hn::Set(d, boxes.high[k][at] + std::max(way[k], 0.0F));
    }
    const std::int32_t first = after ? std::max(i + 1, other_range.begin) : other_range.begin;
    for (std::int32_t j = first; j < other_range.end; j += static_cast<std::int32_t>(hn::Lanes(d))) {
      auto overlaps = hn::Lt(low[0], hn::LoadU(d, &others.high[0][static_cast<std::size_t>(j)]));
      overlaps = hn::And(overlaps, hn::Lt(low[1], hn::LoadU(d, &others.high[1][static_cast<std::size_t>(j)])));
      overlaps = hn::And(overlaps, hn::Lt(low[2], hn::LoadU(d, &others.high[2][static_cast<std::size_t>(j)])));
      overlaps = hn::And(overlaps, hn::Lt(hn::LoadU(d, &others.low[0][static_cast<std::size_t>(j)]), high[0]));
      overlaps = hn::And(overlaps, hn::Lt(hn::LoadU(d, &others.low[1][static_cast<std::size_t>(j)]), high[1]));
      overlaps = hn::And(overlaps, hn::Lt(hn::LoadU(d, &others.low[2][static_cast<std::size_t>(j)]), high[2]));
      if (hn::AllFalse(d, overlaps)) continue;
      for_set_lanes(overlaps, static_cast<std::size_t>(other_range.end - j), [&](int l) {
        found.push_back({i, j + l});
      });
    }
  }
}

HWY_INLINE V square_to_segment(const Vec3& ap, const Vec3& ab) {
  const V t = clamped(hn::Div(dot(ap, ab), hn::Max(dot(ab, ab), hn::Set(D(), 1e-20F))));
  const Vec3 way = plus(ap, ab, hn::Neg(t));
  return dot(way, way);
}

HWY_INLINE V square_of_triangle(const std::array<Vec3, 4>& x) {
  const D d;
  const Vec3 ab = x[2] - x[1], ac = x[3] - x[1], ap = x[0] - x[1];
  const V d00 = dot(ab, ab), d01 = dot(ab, ac), d11 = dot(ac, ac), d20 = dot(ap, ab), d21 = dot(ap, ac);
  const V inverse = hn::Div(hn::Set(d, 1.0F), hn::Sub(hn::Mul(d00, d11), hn::Mul(d01, d01)));
  const V v = hn::Mul(hn::Sub(hn::Mul(d11, d20), hn::Mul(d01, d21)), inverse);
  const V w = hn::Mul(hn::Sub(hn::Mul(d00, d21), hn::Mul(d01, d20)), inverse);
  const auto is_over =
      hn::And(hn::And(hn::Ge(v, hn::Zero(d)), hn::Ge(w, hn::Zero(d))), hn::Le(hn::Add(v, w), hn::Set(d, 1.0F)));
  const Vec3 way = plus(plus(ap, ab, hn::Neg(v)), ac, hn::Neg(w));
  const V edges = hn::Min(hn::Min(square_to_segment(ap, ab), square_to_segment(ap, ac)),
                          square_to_segment(x[0] - x[2], x[3] - x[2]));
  return hn::IfThenElse(is_over, hn::Min(dot(way, way), edges), edges);
}

struct EdgeWay {
  V square;          // m^2
  hn::Mask<D> ends;  // the nearest points are not inside both edges
};
HWY_INLINE EdgeWay way_between_edges(const std::array<Vec3, 4>& x) {
  const D d;
  const V tiny = hn::Set(d, 1e-20F);
  const Vec3 d1 = x[1] - x[0], d2 = x[3] - x[2], r = x[0] - x[2];
  const V a = hn::Max(dot(d1, d1), tiny), e = hn::Max(dot(d2, d2), tiny), f = dot(d2, r), c = dot(d1, r),
          b = dot(d1, d2);
  const V ae = hn::Mul(a, e);
  const V below = hn::Max(hn::Sub(ae, hn::Mul(b, b)), hn::Mul(hn::Set(d, 1e-6F), ae));
  V s = clamped(hn::Div(hn::Sub(hn::Mul(b, f), hn::Mul(c, e)), below));
  const V t = clamped(hn::Div(hn::Add(hn::Mul(b, s), f), e));
  s = clamped(hn::Div(hn::Sub(hn::Mul(b, t), c), a));
  const Vec3 way = plus(plus(r, d1, s), d2, hn::Neg(t));
  const V one = hn::Set(d, 1.0F);
  const auto is_inside =
      hn::And(hn::And(hn::Gt(s, hn::Zero(d)), hn::Lt(s, one)), hn::And(hn::Gt(t, hn::Zero(d)), hn::Lt(t, one)));
  return {dot(way, way), hn::Not(is_inside)};
}

template <FeaturePair::Kind kKind>
HWY_NOINLINE void near_of(const PairLanes& pairs, const MotionLanes& motion, float duration, float reach,
                          std::vector<std::int32_t>& kept) {
  const D d;
  const DI di;
  constexpr std::size_t kNumA = kKind == FeaturePair::Kind::kVertexTriangle ? 1 : 2;
  for (std::size_t p = 0; p < pairs.size(); p += hn::Lanes(d)) {
    const std::size_t left = pairs.size() - p;
    std::array<hn::Vec<DI>, 4> id;
    for (std::size_t i = 0; i < 4; ++i) id[i] = hn::LoadU(di, &pairs.vertices[i][p]);
    auto shares = hn::Or(hn::Eq(id[0], id[2]), hn::Eq(id[0], id[3]));
    shares = hn::Or(shares, hn::Eq(id[1], kNumA == 1 ? id[0] : id[2]));
    if (kNumA == 2) shares = hn::Or(shares, hn::Eq(id[1], id[3]));
    if (hn::AllTrue(di, shares)) continue;
    std::array<Vec3, 4> x, v;
    for (std::size_t i = 0; i < 4; ++i) {
      x[i] = gather(motion.x, id[i]);
      v[i] = gather(motion.v, id[i]);
    }
    V fastest = hn::Zero(d);
    V slack_a = hn::Zero(d), slack_b = hn::Zero(d);
    for (std::size_t i = 0; i < kNumA; ++i) {
      slack_a = hn::Max(slack_a, hn::GatherIndex(d, motion.slack.data(), id[i]));
      for (std::size_t j = kNumA; j < 4; ++j) {
        const Vec3 u = v[i] - v[j];
        fastest = hn::Max(fastest, dot(u, u));
      }
    }
    for (std::size_t j = kNumA; j < 4; ++j) slack_b = hn::Max(slack_b, hn::GatherIndex(d, motion.slack.data(), id[j]));
    const V square = kKind == FeaturePair::Kind::kVertexTriangle ? square_of_triangle(x) : way_between_edges(x).square;
    const V most = hn::Add(hn::Add(hn::Set(d, reach), hn::Add(slack_a, slack_b)),
                           hn::Mul(hn::Set(d, duration), hn::Sqrt(fastest)));
    const auto is_near = hn::AndNot(hn::RebindMask(d, shares), hn::Lt(hn::Sqrt(square), most));
    if (hn::AllFalse(d, is_near)) continue;
    for_set_lanes(is_near, left, [&](int l) { kept.push_back(static_cast<std::int32_t>(p) + l); });
  }
}

void find_near_any(FeaturePair::Kind kind, const PairLanes& pairs, const MotionLanes& motion, float duration,
                   float reach, std::vector<std::int32_t>& kept) {
  if (kind == FeaturePair::Kind::kVertexTriangle) {
    near_of<FeaturePair::Kind::kVertexTriangle>(pairs, motion, duration, reach, kept);
  } else {
    near_of<FeaturePair::Kind::kEdgeEdge>(pairs, motion, duration, reach, kept);
  }
}

template <FeaturePair::Kind kKind>
HWY_NOINLINE void distances_of(const std::array<std::vector<std::int32_t>, 4>& vertices,
                               std::span<const std::int32_t> indices, const std::array<std::vector<float>, 3>& x,
                               std::span<float> distances) {
  const D d;
  const DI di;
  alignas(64) std::array<std::int32_t, 16> index{};
  alignas(64) std::array<float, 16> values{};
  for (std::size_t k = 0; k < indices.size(); k += hn::Lanes(d)) {
    const std::size_t count = std::min(indices.size() - k, hn::Lanes(d));
    std::copy_n(indices.begin() + static_cast<std::ptrdiff_t>(k), count, index.begin());
    const auto pair = hn::Load(di, index.data());
    std::array<Vec3, 4> at;
    for (std::size_t i = 0; i < 4; ++i) at[i] = gather(x, hn::GatherIndex(di, vertices[i].data(), pair));
    if (kKind == FeaturePair::Kind::kVertexTriangle) {
      hn::Store(hn::Sqrt(square_of_triangle(at)), d, values.data());
    } else {
      const EdgeWay way = way_between_edges(at);
      const V distance = hn::Sqrt(way.square);
      hn::Store(hn::IfThenElse(way.ends, hn::Neg(distance), distance), d, values.data());
    }
    std::copy_n(values.begin(), count, distances.begin() + static_cast<std::ptrdiff_t>(k));
  }
}

void find_distances_any(FeaturePair::Kind kind, const std::array<std::vector<std::int32_t>, 4>& vertices,
                        std::span<const std::int32_t> indices, const std::array<std::vector<float>, 3>& x,
                        std::span<float> distances) {
  if (kind == FeaturePair::Kind::kVertexTriangle) {
    distances_of<FeaturePair::Kind::kVertexTriangle>(vertices, indices, x, distances);
  } else {
    distances_of<FeaturePair::Kind::kEdgeEdge>(vertices, indices, x, distances);
  }
}

// Appends the indices of pairs for which is_kept(sum of `values` over their vertices, index of the first pair) is set.
template <typename IsKept>
HWY_INLINE void keep_by_sum(const std::array<std::vector<std::int32_t>, 4>& vertices, std::size_t count,
                            std::span<const float> values, const IsKept& is_kept, std::vector<std::int32_t>& kept) {
  const D d;
  const DI di;
  for (std::size_t p = 0; p < count; p += hn::Lanes(d)) {
    V sum = hn::Zero(d);
    for (std::size_t i = 0; i < 4; ++i) {
      sum = hn::Add(sum, hn::GatherIndex(d, values.data(), hn::LoadU(di, &vertices[i][p])));
    }
    const auto mask = is_kept(sum, p);
    if (hn::AllFalse(d, mask)) continue;
    for_set_lanes(mask, count - p, [&](int l) { kept.push_back(static_cast<std::int32_t>(p) + l); });
  }
}

void find_due_any(const std::array<std::vector<std::int32_t>, 4>& vertices, std::span<const float> path,
                  std::span<const float> limit, std::vector<std::int32_t>& due) {
  const auto is_due = [&](V sum, std::size_t p) { return hn::Not(hn::Lt(sum, hn::LoadU(D(), &limit[p]))); };
  keep_by_sum(vertices, limit.size(), path, is_due, due);
}

void find_marked_any(const std::array<std::vector<std::int32_t>, 4>& vertices, std::size_t count,
                     std::span<const float> marks, std::vector<std::int32_t>& marked) {
  keep_by_sum(
      vertices, count, marks, [](V sum, std::size_t) { return hn::Gt(sum, hn::Zero(D())); }, marked);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::contact
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::contact {
namespace {
HWY_EXPORT(find_overlaps_any);
HWY_EXPORT(find_near_any);
HWY_EXPORT(find_distances_any);
HWY_EXPORT(find_due_any);
HWY_EXPORT(find_marked_any);
}  // namespace

void BoxLanes::resize(std::size_t count) {
  for (std::size_t k = 0; k < 3; ++k) {
    low[k].resize(count + kLanePadding);
    high[k].resize(count + kLanePadding);
  }
}

void MotionLanes::resize(std::size_t count) {
  for (std::size_t k = 0; k < 3; ++k) {
    x[k].resize(count);
    v[k].resize(count);
  }
  slack.resize(count);
}

void PairLanes::clear() {
  a.clear();
  b.clear();
  for (std::vector<std::int32_t>& of : vertices) of.clear();
}

void PairLanes::add(std::int32_t feature_a, std::int32_t feature_b, const std::array<mesh::VertexId, 4>& of) {
  a.push_back(feature_a);
  b.push_back(feature_b);
  for (std::size_t i = 0; i < 4; ++i) vertices[i].push_back(of[i]);
}

void find_overlaps(const BoxLanes& boxes, BoxRange range, const float* way, const BoxLanes& others,
                   BoxRange other_range, bool after, std::vector<std::array<std::int32_t, 2>>& found) {
  HWY_DYNAMIC_DISPATCH(find_overlaps_any)(boxes, range, way, others, other_range, after, found);
}

void PairLanes::pad() {
  for (std::vector<std::int32_t>& of : vertices) of.resize(size() + kLanePadding, 0);
}

void find_near(FeaturePair::Kind kind, const PairLanes& pairs, const MotionLanes& motion, float duration, float reach,
               std::vector<std::int32_t>& kept) {
  kept.clear();
  HWY_DYNAMIC_DISPATCH(find_near_any)(kind, pairs, motion, duration, reach, kept);
}

void find_distances(FeaturePair::Kind kind, const std::array<std::vector<std::int32_t>, 4>& vertices,
                    std::span<const std::int32_t> indices, const std::array<std::vector<float>, 3>& x,
                    std::span<float> distances) {
  HWY_DYNAMIC_DISPATCH(find_distances_any)(kind, vertices, indices, x, distances);
}

void find_due(const std::array<std::vector<std::int32_t>, 4>& vertices, std::span<const float> path,
              std::span<const float> limit, std::vector<std::int32_t>& due) {
  due.clear();
  HWY_DYNAMIC_DISPATCH(find_due_any)(vertices, path, limit, due);
}

void find_marked(const std::array<std::vector<std::int32_t>, 4>& vertices, std::size_t count,
                 std::span<const float> marks, std::vector<std::int32_t>& marked) {
  marked.clear();
  HWY_DYNAMIC_DISPATCH(find_marked_any)(vertices, count, marks, marked);
}

}  // namespace kerf::contact
#endif  // HWY_ONCE
