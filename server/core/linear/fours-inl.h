// Vectors of four numbers for each of a few vertices, side by side. Compiled once for each vector instruction set.
#if defined(KERF_LINEAR_FOURS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KERF_LINEAR_FOURS_INL_H
#undef KERF_LINEAR_FOURS_INL_H
#else
#define KERF_LINEAR_FOURS_INL_H
#endif

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf::linear {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// Vector type of up to four groups of four.
template <typename T>
using Fours = hn::CappedTag<T, HWY_HAVE_SCALABLE ? 4 : 16>;

#if HWY_TARGET == HWY_SCALAR
template <class D>
HWY_INLINE hn::Vec<D> joined(D /*d*/, hn::Vec<D> /*high*/, hn::Vec<D> low) {
  return low;  // never called
}
#else
template <class D>
HWY_INLINE hn::Vec<D> joined(D d, hn::Vec<hn::Half<D>> high, hn::Vec<hn::Half<D>> low) {
  return hn::Combine(d, high, low);
}
#endif

// Loads x, y, z, 0 from offsets at[0], at[1], ... of an array "x 4", which holds x, y, z and a 0 of each vertex. With
// fewer than four lanes, loads from at[0] only, beginning with component `part`.
template <class D>
HWY_INLINE hn::Vec<D> load_fours(D d, const hn::TFromD<D>* from, const std::int32_t* at, std::size_t part = 0) {
  if constexpr (hn::MaxLanes(D()) <= 4) {
    return hn::LoadU(d, from + static_cast<std::ptrdiff_t>(at[0]) + part);
  } else {
    const hn::Half<D> half;
    constexpr std::size_t kVertices = hn::MaxLanes(hn::Half<D>()) / 4;
    return joined(d, load_fours(half, from, at + kVertices), load_fours(half, from, at));
  }
}

// Returns values[first], values[first + 1], ..., each repeated four times, as many as fill the vector.
template <class D>
HWY_INLINE hn::Vec<D> spread(D d, const std::array<hn::TFromD<D>, 4>& values, std::size_t first) {
  if constexpr (hn::MaxLanes(D()) <= 4) {
    return hn::Set(d, values[first]);
  } else if constexpr (std::is_same_v<hn::TFromD<D>, float>) {
    const hn::RebindToSigned<D> di;
    const auto which = hn::Add(hn::ShiftRight<2>(hn::Iota(di, 0)), hn::Set(di, static_cast<std::int32_t>(first)));
    return hn::TableLookupLanes(hn::LoadDup128(d, values.data()), hn::IndicesFromVec(d, which));
  } else {
    const hn::Half<D> half;
    constexpr std::size_t kValues = hn::MaxLanes(hn::Half<D>()) / 4;
    return joined(d, spread(half, values, first + kValues), spread(half, values, first));
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::linear
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
