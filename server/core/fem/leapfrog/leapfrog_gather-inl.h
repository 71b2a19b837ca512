// Forces of leapfrog_kernels.cc that access scattered memory: those of irregular triangles, and of the bending matrix
// by rows. Compiled once for each instruction set.
#if defined(KERF_FEM_LEAPFROG_GATHER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KERF_FEM_LEAPFROG_GATHER_INL_H
#undef KERF_FEM_LEAPFROG_GATHER_INL_H
#else
#define KERF_FEM_LEAPFROG_GATHER_INL_H
#endif

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include "server/core/fem/leapfrog/leapfrog_kernels.h"
#include "server/core/fem/leapfrog/leapfrog_triangles-inl.h"
#include "server/core/linear/fours-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kerf::fem {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using linear::HWY_NAMESPACE::Fours;
using linear::HWY_NAMESPACE::load_fours;
using linear::HWY_NAMESPACE::spread;

constexpr std::size_t kBlocksAtOnce = 4;  // irregular blocks whose corners are fetched together

// Number of groups of four vertices by which rows of the bending matrix are prefetched. This is done only for rows that
// do not begin where those of the previous group end. Cuts cause that when rows grow. The processor itself prefetches
// all other rows.
inline constexpr std::size_t kGroupsAhead = 4;

template <typename T>
HWY_INLINE void fetch_moved(std::span<const FourEntries<T>> before, std::span<const FourEntries<T>> entries) {
  constexpr std::size_t kInLine = HWY_MAX(std::size_t{1}, 64 / sizeof(FourEntries<T>));
  if (before.data() + before.size() == entries.data()) return;
  for (std::size_t i = 0; i < entries.size(); i += kInLine) hwy::Prefetch(entries.data() + i);
}

// Completes the bending forces of the vertices of a block, in `gathered`. Adds the entries that lie in no diagonal,
// four rows side by side, and scales the sum. If `is_gathered` the sum begins with that of the diagonals.
template <typename T>
HWY_NOINLINE void bending_by_rows(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step, std::size_t block,
                                  bool is_gathered) {
  constexpr std::size_t kRows = FourEntries<T>::kRows;
  const Fours<T> d;
  const Fours<PositionOf<T>> dp;
  const auto scale = hn::Set(d, step.bending_scale);
  const auto num_groups = static_cast<std::size_t>(arrays.bending->num_groups());
  const std::size_t first = block * linear::kBlockLanes / kRows;
  const std::size_t last = HWY_MIN(first + linear::kBlockLanes / kRows, num_groups);
  for (std::size_t group = first; group < last; ++group) {
    const std::span<const FourEntries<T>> entries = arrays.bending->rest(static_cast<int>(group));
    if (group + kGroupsAhead < num_groups) {
      const auto ahead = static_cast<int>(group + kGroupsAhead);
      fetch_moved(arrays.bending->rest(ahead - 1), arrays.bending->rest(ahead));
    }
    for (std::size_t part = 0; part < 4 * kRows; part += hn::Lanes(d)) {
      const std::size_t at = 4 * kRows * group + part;
      const auto xi = hn::LoadU(dp, arrays.bending_fours + at);
      auto sum = is_gathered ? hn::LoadU(d, arrays.gathered + at) : hn::Zero(d);
      for (const FourEntries<T>& entry : entries) {
        const auto xj = load_fours(dp, arrays.bending_fours, entry.place.data() + part / 4, part % 4);
        const auto value = spread(d, entry.value, part / 4);
        sum = hn::Add(sum, hn::Mul(value, converted(d, hn::Sub(xi, xj))));
      }
      hn::StoreU(hn::Mul(sum, scale), d, arrays.gathered + at);
    }
  }
}

// Adds forces of irregular corners around the vertices of a block, and extra_force, to `gathered`. If `is_gathered` is
// false the sum begins at 0.
template <typename T>
HWY_NOINLINE void add_corners(const LeapfrogArrays<T>& arrays, std::size_t block, bool is_gathered) {
  constexpr std::size_t kVertices = CornerPlaces().size();
  const Fours<T> d;
  const std::size_t first = block * linear::kBlockLanes / kVertices;
  const std::size_t last =
      HWY_MIN(first + linear::kBlockLanes / kVertices, static_cast<std::size_t>(arrays.corners->num_rows()));
  for (std::size_t group = first; group < last; ++group) {
    const std::span<const CornerPlaces> corners = arrays.corners->row(static_cast<int>(group));
    for (std::size_t part = 0; part < 4 * kVertices; part += hn::Lanes(d)) {
      const std::size_t at = 4 * kVertices * group + part;
      auto sum = is_gathered ? hn::LoadU(d, arrays.gathered + at) : hn::Zero(d);
      for (const CornerPlaces& places : corners) {
        sum = hn::Add(sum, load_fours(d, arrays.corner_force, places.data() + part / 4, part % 4));
      }
      if (arrays.extra_force != nullptr) sum = hn::Add(sum, hn::LoadU(d, arrays.extra_force + at));
      hn::StoreU(sum, d, arrays.gathered + at);
    }
  }
}

#if HWY_TARGET != HWY_SCALAR
// Returns the columns of the 4x4 matrix in each four lanes of four vectors, without the last one.
template <class D, class V = hn::Vec<D>>
HWY_INLINE Vec3<V> columns(D d, V a, V b, V c, V e) {
  const hn::RepartitionToWide<D> pairs;
  const auto lower_ab = hn::BitCast(pairs, hn::InterleaveLower(d, a, b));
  const auto lower_ce = hn::BitCast(pairs, hn::InterleaveLower(d, c, e));
  const auto upper_ab = hn::BitCast(pairs, hn::InterleaveUpper(d, a, b));
  const auto upper_ce = hn::BitCast(pairs, hn::InterleaveUpper(d, c, e));
  return {hn::BitCast(d, hn::InterleaveLower(pairs, lower_ab, lower_ce)),
          hn::BitCast(d, hn::InterleaveUpper(pairs, lower_ab, lower_ce)),
          hn::BitCast(d, hn::InterleaveLower(pairs, upper_ab, upper_ce))};
}
// Inverts columns(), with a last column of 0.
template <class D, class V = hn::Vec<D>>
HWY_INLINE std::array<V, 4> rows(D d, const Vec3<V>& columns) {
  const hn::RepartitionToWide<D> pairs;
  const V zero = hn::Zero(d);
  const auto lower_xy = hn::BitCast(pairs, hn::InterleaveLower(d, columns.x, columns.y));
  const auto lower_z = hn::BitCast(pairs, hn::InterleaveLower(d, columns.z, zero));
  const auto upper_xy = hn::BitCast(pairs, hn::InterleaveUpper(d, columns.x, columns.y));
  const auto upper_z = hn::BitCast(pairs, hn::InterleaveUpper(d, columns.z, zero));
  return {hn::BitCast(d, hn::InterleaveLower(pairs, lower_xy, lower_z)),
          hn::BitCast(d, hn::InterleaveUpper(pairs, lower_xy, lower_z)),
          hn::BitCast(d, hn::InterleaveLower(pairs, upper_xy, upper_z)),
          hn::BitCast(d, hn::InterleaveUpper(pairs, upper_xy, upper_z))};
}
#endif

// Positions of the corners of irregular triangles. fetch() copies those of several blocks at once, because the
// processor cannot read as one vector what was just written piece by piece.
template <typename P>
class CornerPositions {
 public:
  template <typename T>
  HWY_INLINE void fetch(const LeapfrogArrays<T>& arrays, std::size_t first, std::size_t last) {
    for (std::size_t b = first; b < last; ++b) {
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t l = 0; l < linear::kBlockLanes; ++l) {
          std::memcpy(corner_[b - first][k] + 4 * l, arrays.corner_x + arrays.irregular[b].from[k][l], 4 * sizeof(P));
        }
      }
    }
  }
  // Returns corner k of the triangles in lanes l, l + 1, ... of block `b` after the first.
  template <class DP>
  HWY_INLINE Vec3<hn::Vec<DP>> load(DP dp, std::size_t b, std::size_t k, std::size_t l) const {
    Vec3<hn::Vec<DP>> x;
    hn::Vec<DP> none;
    hn::LoadInterleaved4(dp, corner_[b][k] + 4 * l, x.x, x.y, x.z, none);
    return x;
  }

 private:
  alignas(64) P corner_[kBlocksAtOnce][3][4 * linear::kBlockLanes];
};

// Fixed-point positions are transposed in registers instead of being copied.
template <>
class CornerPositions<std::int32_t> {
 public:
  HWY_INLINE void fetch(const LeapfrogArrays<float>& arrays, std::size_t first, std::size_t /*last*/) {
    corner_x_ = arrays.corner_x;
    blocks_ = &arrays.irregular[first];
  }
  template <class DP>
  HWY_INLINE Vec3<hn::Vec<DP>> load(DP dp, std::size_t b, std::size_t k, std::size_t l) const {
    const std::int32_t* const from = blocks_[b].from[k].data();
#if HWY_TARGET == HWY_SCALAR
    Vec3<hn::Vec<DP>> x;
    hn::Vec<DP> none;
    hn::LoadInterleaved4(dp, corner_x_ + from[irregular_lane<float>(l)], x.x, x.y, x.z, none);
    return x;
#else
    const auto load = [&](std::size_t i) HWY_ATTR { return load_fours(dp, corner_x_, from + 4 * i + l / 4); };
    return columns(dp, load(0), load(1), load(2), load(3));
#endif
  }

 private:
  const std::int32_t* corner_x_ = nullptr;
  const IrregularBlock<float>* blocks_ = nullptr;
};

// Stores the forces on one corner of the triangles in lanes l, l + 1, ... of a block. `to` is the place for that corner
// of lane 0.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void store_corner(D d, const Vec3<V>& force, std::size_t l, hn::TFromD<D>* to) {
  using T = hn::TFromD<D>;
#if HWY_TARGET != HWY_SCALAR
  if constexpr (std::is_same_v<T, float>) {
    const std::array<V, 4> made = rows(d, force);
    for (std::size_t i = 0; i < 4; ++i) hn::StoreU(made[i], d, to + 4 * (4 * i + l / 4));
    return;
  }
#endif
  hn::StoreInterleaved4(force.x, force.y, force.z, hn::Zero(d), d, to + 4 * irregular_lane<T>(l));
}

template <MembraneLaw kLaw, typename T>
HWY_NOINLINE void irregular_forces(const LeapfrogArrays<T>& arrays, const LeapfrogStep<T>& step) {
  using Position = PositionOf<T>;
  using D = Fours<T>;
  using V = hn::Vec<D>;
  const D d;
  const hn::Rebind<Position, D> dp;
  const auto common = common_law(d, step);
  const LawLanes<T>* const laws = arrays.irregular_laws;
  const bool from_start = arrays.irregular_start != nullptr;
  CornerPositions<Position> corners;
  const std::size_t num_blocks = arrays.irregular.size();
  for (std::size_t first = 0; first < num_blocks; first += kBlocksAtOnce) {
    const std::size_t last = HWY_MIN(first + kBlocksAtOnce, num_blocks);
    corners.fetch(arrays, first, last);
    StretchLanes<T> stretches[kBlocksAtOnce];
    for (std::size_t b = first; kLaw == MembraneLaw::kCorotational && b < last; ++b) {
      for (std::size_t l = 0; l < linear::kBlockLanes; l += hn::Lanes(d)) {
        const auto x0 = corners.load(dp, b - first, 0, l);
        const Vec3<V> d1 = edge(d, corners.load(dp, b - first, 1, l), x0);
        const Vec3<V> d2 = edge(d, corners.load(dp, b - first, 2, l), x0);
        const TriangleLanes<T>& triangles = arrays.irregular[b].triangles;
        if (from_start) {
          set_gradients(d, triangles, arrays.irregular_start[b], l, d1, d2, stretches[b - first]);
        } else {
          set_gradients(d, triangles, l, d1, d2, stretches[b - first]);
        }
      }
    }
    if (kLaw == MembraneLaw::kCorotational) {
      from_start ? set_strains_from_start(stretches, last - first) : set_strains(stretches, last - first);
    }
    for (std::size_t b = first; b < last; ++b) {
      for (std::size_t l = 0; l < linear::kBlockLanes; l += hn::Lanes(d)) {
        IrregularBlock<T>& block = arrays.irregular[b];
        CornerForces<V> forces;
        if constexpr (kLaw == MembraneLaw::kGreen) {
          const auto x0 = corners.load(dp, b - first, 0, l);
          const Vec3<V> d1 = edge(d, corners.load(dp, b - first, 1, l), x0);
          const Vec3<V> d2 = edge(d, corners.load(dp, b - first, 2, l), x0);
          forces = edge_forces(d, laws == nullptr ? common.damping : damping_of(d, laws[b], l),
                               arrays.irregular_edges[b], l, d1, d2, block.before);
        } else {
          forces = corner_forces(d, laws == nullptr ? common : law_of(d, laws[b], l), block.triangles, l,
                                 stretches[b - first], block.before);
        }
        const Vec3<V> sum = plus(forces.force1, forces.force2);
        T* const to = arrays.corner_force + 4 * 3 * b * linear::kBlockLanes;
        store_corner(d, {hn::Neg(sum.x), hn::Neg(sum.y), hn::Neg(sum.z)}, l, to);
        store_corner(d, forces.force1, l, to + 4 * linear::kBlockLanes);
        store_corner(d, forces.force2, l, to + 8 * linear::kBlockLanes);
      }
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::fem
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
