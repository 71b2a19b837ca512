#include "server/core/contact/pair_looks.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/contact/pair_looks.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "server/core/contact/pair_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kerf::contact {
namespace HWY_NAMESPACE {
namespace {

// Calls look(pairs, place, count) for each block of pairs selected.
template <typename Look>
HWY_INLINE void for_blocks(const PairSelection& pairs, const Look& look) {
  const DI di;
  alignas(64) std::array<std::int32_t, 16> index{};
  for (std::size_t k = 0; k < pairs.indices.size(); k += hn::Lanes(di)) {
    const std::size_t count = std::min(pairs.indices.size() - k, hn::Lanes(di));
    std::copy_n(pairs.indices.begin() + static_cast<std::ptrdiff_t>(k), count, index.begin());
    look(hn::Load(di, index.data()), k, count);
  }
}

HWY_INLINE std::array<hn::Vec<DI>, 4> vertices_of(const PairSelection& pairs, hn::Vec<DI> index) {
  std::array<hn::Vec<DI>, 4> id;
  for (std::size_t i = 0; i < 4; ++i) id[i] = hn::GatherIndex(DI(), pairs.vertices[i].data(), index);
  return id;
}

HWY_INLINE std::array<Vec3, 4> gather(const FloatLanes& from, const std::array<hn::Vec<DI>, 4>& id) {
  return {gather(from, id[0]), gather(from, id[1]), gather(from, id[2]), gather(from, id[3])};
}

template <FeaturePair::Kind kKind>
HWY_NOINLINE void look_at_kind(const PairSelection& pairs, const FloatLanes& x, const FloatLanes& v,
                               std::span<float> distances, std::span<float> closing) {
  const D d;
  alignas(64) std::array<float, 16> values{};
  for_blocks(pairs, [&](hn::Vec<DI> index, std::size_t place, std::size_t count) {
    const std::array<hn::Vec<DI>, 4> id = vertices_of(pairs, index);
    const Nearest nearest = nearest_of<kKind>(gather(x, id));
    const std::array<Vec3, 4> u = gather(v, id);
    Vec3 relative;
    if (kKind == FeaturePair::Kind::kVertexTriangle) {
      relative = plus(plus(u[0] - u[1], u[2] - u[1], hn::Neg(nearest.s)), u[3] - u[1], hn::Neg(nearest.t));
    } else {
      relative = plus(plus(u[0] - u[2], u[1] - u[0], nearest.s), u[3] - u[2], hn::Neg(nearest.t));
    }
    const V distance = hn::Sqrt(nearest.square);
    const V along = hn::Div(dot(relative, nearest.way), hn::Max(distance, hn::Set(d, 1e-20F)));
    const auto at = static_cast<std::ptrdiff_t>(place);
    hn::Store(hn::Neg(along), d, values.data());
    std::copy_n(values.begin(), count, closing.begin() + at);
    const bool is_edges = kKind == FeaturePair::Kind::kEdgeEdge;
    hn::Store(is_edges ? hn::IfThenElse(nearest.ends, hn::Neg(distance), distance) : distance, d, values.data());
    std::copy_n(values.begin(), count, distances.begin() + at);
  });
}

void look_at_any(const PairSelection& pairs, const FloatLanes& x, const FloatLanes& v, std::span<float> distances,
                 std::span<float> closing) {
  if (pairs.kind == FeaturePair::Kind::kVertexTriangle) {
    look_at_kind<FeaturePair::Kind::kVertexTriangle>(pairs, x, v, distances, closing);
  } else {
    look_at_kind<FeaturePair::Kind::kEdgeEdge>(pairs, x, v, distances, closing);
  }
}

// Returns the gap between both sides along `normal`.
template <FeaturePair::Kind kKind>
HWY_INLINE V gap_of(const std::array<Vec3, 4>& x, const Vec3& normal) {
  const D d;
  const V h0 = dot(normal, x[0] - x[3]), h1 = dot(normal, x[1] - x[3]), h2 = dot(normal, x[2] - x[3]);
  const V zero = hn::Zero(d);
  return kKind == FeaturePair::Kind::kVertexTriangle ? hn::Sub(h0, hn::Max(hn::Max(h1, h2), zero))
                                                     : hn::Sub(hn::Min(h0, h1), hn::Max(h2, zero));
}

template <FeaturePair::Kind kKind>
HWY_NOINLINE void keep_unseparated_kind(const PairSelection& pairs, std::span<const float> least,
                                        const FloatPositions& from, const FloatPositions& to,
                                        std::vector<std::int32_t>& kept) {
  const D d;
  const V rounding = hn::Set(d, std::max(from.rounding(), to.rounding()));
  for_blocks(pairs, [&](hn::Vec<DI> index, std::size_t place, std::size_t count) {
    const std::array<hn::Vec<DI>, 4> id = vertices_of(pairs, index);
    const std::array<Vec3, 4> then = gather(from.x, id), now = gather(to.x, id);
    const Nearest nearest = nearest_of<kKind>(then);
    const V distance = hn::Sqrt(nearest.square);
    const V inverse = hn::Div(hn::Set(d, 1.0F), hn::Max(distance, hn::Set(d, 1e-20F)));
    const Vec3 normal{hn::Mul(nearest.way.x, inverse), hn::Mul(nearest.way.y, inverse),
                      hn::Mul(nearest.way.z, inverse)};
    const V floor = hn::Min(hn::GatherIndex(d, least.data(), index), hn::Mul(hn::Set(d, 0.999F), distance));
    const V gap = hn::Add(hn::Max(hn::Mul(hn::Set(d, 0.1F), distance), floor), rounding);
    const auto is_separated =
        hn::And(hn::Gt(gap_of<kKind>(then, normal), gap), hn::Gt(gap_of<kKind>(now, normal), gap));
    const auto is_kept = hn::Not(is_separated);
    if (hn::AllFalse(d, is_kept)) return;
    for_set_lanes(is_kept, count, [&](int l) { kept.push_back(pairs.indices[place + static_cast<std::size_t>(l)]); });
  });
}

void keep_unseparated_any(const PairSelection& pairs, std::span<const float> least, const FloatPositions& from,
                          const FloatPositions& to, std::vector<std::int32_t>& kept) {
  if (pairs.kind == FeaturePair::Kind::kVertexTriangle) {
    keep_unseparated_kind<FeaturePair::Kind::kVertexTriangle>(pairs, least, from, to, kept);
  } else {
    keep_unseparated_kind<FeaturePair::Kind::kEdgeEdge>(pairs, least, from, to, kept);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::contact
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::contact {
namespace {
HWY_EXPORT(look_at_any);
HWY_EXPORT(keep_unseparated_any);
}  // namespace

void set_floats(const linear::VertexField& from, std::span<const mesh::VertexId> vertices, FloatLanes& to) {
  for (std::size_t k = 0; k < 3; ++k) to[k].resize(static_cast<std::size_t>(from.cols()));
  for (const mesh::VertexId v : vertices) {
    for (std::size_t k = 0; k < 3; ++k) {
      to[k][static_cast<std::size_t>(v)] = static_cast<float>(from(static_cast<Eigen::Index>(k), v));
    }
  }
}

void FloatPositions::set(const linear::VertexField& from, std::span<const mesh::VertexId> vertices) {
  middle.setZero();
  for (const mesh::VertexId v : vertices) middle += from.col(v);
  middle /= static_cast<double>(std::max<std::size_t>(vertices.size(), 1));
  for (std::size_t k = 0; k < 3; ++k) x[k].resize(static_cast<std::size_t>(from.cols()));
  extent = 0.0F;
  update(from, vertices);
}

void FloatPositions::update(const linear::VertexField& from, std::span<const mesh::VertexId> vertices) {
  float largest = extent;
  for (const mesh::VertexId v : vertices) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      const auto value = static_cast<float>(from(axis, v) - middle[axis]);
      x[k][static_cast<std::size_t>(v)] = value;
      largest = std::max(largest, std::abs(value));
    }
  }
  extent = largest;
}

void look_at(const PairSelection& pairs, const FloatLanes& x, const FloatLanes& v, std::span<float> distances,
             std::span<float> closing) {
  HWY_DYNAMIC_DISPATCH(look_at_any)(pairs, x, v, distances, closing);
}

void keep_unseparated(const PairSelection& pairs, std::span<const float> least, const FloatPositions& from,
                      const FloatPositions& to, std::vector<std::int32_t>& kept) {
  HWY_DYNAMIC_DISPATCH(keep_unseparated_any)(pairs, least, from, to, kept);
}

}  // namespace kerf::contact
#endif  // HWY_ONCE
