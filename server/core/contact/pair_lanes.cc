#include "server/core/contact/pair_lanes.h"

#include <algorithm>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/contact/pair_lanes.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "server/core/contact/pair_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kerf::contact {
namespace HWY_NAMESPACE {
namespace {

struct LaneBox {
  std::array<V, 3> low, high;
};
// Returns the lanes in which two boxes overlap.
HWY_INLINE hn::Mask<D> overlaps(const LaneBox& a, const LaneBox& b) {
  auto all = hn::And(hn::Lt(a.low[0], b.high[0]), hn::Lt(b.low[0], a.high[0]));
  all = hn::And(all, hn::And(hn::Lt(a.low[1], b.high[1]), hn::Lt(b.low[1], a.high[1])));
  return hn::And(all, hn::And(hn::Lt(a.low[2], b.high[2]), hn::Lt(b.low[2], a.high[2])));
}
HWY_INLINE LaneBox boxes_at(const BoxLanes& boxes, std::int32_t first) {
  const D d;
  const auto at = static_cast<std::size_t>(first);
  return {{hn::LoadU(d, &boxes.low[0][at]), hn::LoadU(d, &boxes.low[1][at]), hn::LoadU(d, &boxes.low[2][at])},
          {hn::LoadU(d, &boxes.high[0][at]), hn::LoadU(d, &boxes.high[1][at]), hn::LoadU(d, &boxes.high[2][at])}};
}

void find_overlaps_any(const BoxLanes& boxes, BoxRange range, const float* way, const BoxLanes& others,
                       BoxRange other_range, const BoxBounds& bounds, bool after,
                       std::vector<std::array<std::int32_t, 2>>& found) {
  const D d;
  const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
  LaneBox around;
  for (std::size_t k = 0; k < 3; ++k) {
    around.low[k] = hn::Set(d, bounds.low[k] - std::max(way[k], 0.0F));
    around.high[k] = hn::Set(d, bounds.high[k] - std::min(way[k], 0.0F));
  }
  for (std::int32_t block = range.begin; block < range.end; block += lanes) {
    const auto reaches = overlaps(boxes_at(boxes, block), around);
    for_set_lanes(reaches, static_cast<std::size_t>(range.end - block), [&](int lane) {
      const std::int32_t i = block + lane;
      const auto at = static_cast<std::size_t>(i);
      LaneBox box;
      for (std::size_t k = 0; k < 3; ++k) {
        box.low[k] = hn::Set(d, boxes.low[k][at] + std::min(way[k], 0.0F));
        box.high[k] = hn::Set(d, boxes.high[k][at] + std::max(way[k], 0.0F));
      }
      const std::int32_t first = after ? std::max(i + 1, other_range.begin) : other_range.begin;
      for (std::int32_t j = first; j < other_range.end; j += lanes) {
        const auto are_near = overlaps(box, boxes_at(others, j));
        if (hn::AllFalse(d, are_near)) continue;
        for_set_lanes(are_near, static_cast<std::size_t>(other_range.end - j), [&](int l) {
          found.push_back({i, j + l});
        });
      }
    });
  }
}

template <FeaturePair::Kind kKind>
HWY_NOINLINE void near_of(const PairLanes& pairs, const MotionLanes& motion, float duration, float reach,
                          std::vector<std::int32_t>& kept, std::vector<float>& speeds) {
  const D d;
  const DI di;
  alignas(64) std::array<float, 16> speed{};
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
    const V square = nearest_of<kKind>(x).square;
    fastest = hn::Sqrt(fastest);
    const V most =
        hn::Add(hn::Add(hn::Set(d, reach), hn::Add(slack_a, slack_b)), hn::Mul(hn::Set(d, duration), fastest));
    const auto is_near = hn::AndNot(hn::RebindMask(d, shares), hn::Lt(hn::Sqrt(square), most));
    if (hn::AllFalse(d, is_near)) continue;
    hn::Store(fastest, d, speed.data());
    for_set_lanes(is_near, left, [&](int l) {
      kept.push_back(static_cast<std::int32_t>(p) + l);
      speeds.push_back(speed[static_cast<std::size_t>(l)]);
    });
  }
}

void find_near_any(FeaturePair::Kind kind, const PairLanes& pairs, const MotionLanes& motion, float duration,
                   float reach, std::vector<std::int32_t>& kept, std::vector<float>& speeds) {
  if (kind == FeaturePair::Kind::kVertexTriangle) {
    near_of<FeaturePair::Kind::kVertexTriangle>(pairs, motion, duration, reach, kept, speeds);
  } else {
    near_of<FeaturePair::Kind::kEdgeEdge>(pairs, motion, duration, reach, kept, speeds);
  }
}

void find_due_any(const std::array<std::vector<std::int32_t>, 4>& vertices, const PairWays& ways,
                  std::span<const float> limit, std::vector<std::int32_t>& due, std::vector<float>& way) {
  const D d;
  const DI di;
  alignas(64) std::array<float, 16> sums{};
  for (std::size_t p = 0; p < limit.size(); p += hn::Lanes(d)) {
    V sum = hn::Zero(d);
    for (std::size_t i = 0; i < 4; ++i) {
      sum = hn::Add(sum, hn::GatherIndex(d, ways.path.data(), hn::LoadU(di, &vertices[i][p])));
    }
    sum = hn::Add(sum, hn::Mul(hn::LoadU(d, &ways.speed[p]), hn::Set(d, ways.elapsed)));
    const auto is_due = hn::Not(hn::Lt(sum, hn::LoadU(d, &limit[p])));
    if (hn::AllFalse(d, is_due)) continue;
    hn::Store(sum, d, sums.data());
    for_set_lanes(is_due, limit.size() - p, [&](int l) {
      due.push_back(static_cast<std::int32_t>(p) + l);
      way.push_back(sums[static_cast<std::size_t>(l)]);
    });
  }
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
HWY_EXPORT(find_due_any);
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

void PairLanes::resize(std::size_t count) {
  a.resize(count);
  b.resize(count);
  for (std::vector<std::int32_t>& of : vertices) {
    of.resize(count + kLanePadding);
    std::fill(of.end() - static_cast<std::ptrdiff_t>(kLanePadding), of.end(), 0);
  }
}

void find_overlaps(const BoxLanes& boxes, BoxRange range, const float* way, const BoxLanes& others,
                   BoxRange other_range, const BoxBounds& bounds, bool after,
                   std::vector<std::array<std::int32_t, 2>>& found) {
  HWY_DYNAMIC_DISPATCH(find_overlaps_any)(boxes, range, way, others, other_range, bounds, after, found);
}

void find_near(FeaturePair::Kind kind, const PairLanes& pairs, const MotionLanes& motion, float duration, float reach,
               std::vector<std::int32_t>& kept, std::vector<float>& speeds) {
  kept.clear();
  speeds.clear();
  HWY_DYNAMIC_DISPATCH(find_near_any)(kind, pairs, motion, duration, reach, kept, speeds);
}

void find_due(const std::array<std::vector<std::int32_t>, 4>& vertices, const PairWays& ways,
              std::span<const float> limit, std::vector<std::int32_t>& due, std::vector<float>& way) {
  due.clear();
  way.clear();
  HWY_DYNAMIC_DISPATCH(find_due_any)(vertices, ways, limit, due, way);
}

}  // namespace kerf::contact
#endif  // HWY_ONCE
