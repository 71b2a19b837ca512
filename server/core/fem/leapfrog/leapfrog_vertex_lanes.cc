#include "server/core/fem/leapfrog/leapfrog_vertex_lanes.h"

#include <array>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/fem/leapfrog/leapfrog_vertex_lanes.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf::fem {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, linear::kBlockLanes>;
using V = hn::Vec<D>;

HWY_INLINE V widened(D d, const double* from) {
  return hn::Load(d, from);
}
template <typename U>
HWY_INLINE V widened(D d, const U* from) {
  return hn::PromoteTo(d, hn::Load(hn::Rebind<U, D>(), from));
}

// Returns the origins, m, of the positions of the vertices from i on.
HWY_INLINE std::array<V, 3> starts_at(D d, const PositionFrame& frame, std::size_t i) {
  std::array<V, 3> from{hn::Set(d, frame.origin[0]), hn::Set(d, frame.origin[1]), hn::Set(d, frame.origin[2])};
  if (frame.starts != nullptr) hn::LoadInterleaved3(d, frame.starts + 3 * i, from[0], from[1], from[2]);
  return from;
}

struct Motion {
  std::array<V, 3> x, v;  // m, m/s
};
template <typename T>
HWY_INLINE Motion motion_at(D d, const LeapfrogArrays<T>& arrays, const PositionFrame& frame, std::size_t i) {
  const std::array<V, 3> from = starts_at(d, frame, i);
  Motion motion;
  for (std::size_t c = 0; c < 3; ++c) {
    V x = widened(d, arrays.x[c] + i);
    V v = widened(d, arrays.v[c] + i);
    if constexpr (std::is_same_v<T, float>) {
      x = hn::Add(x, widened(d, arrays.remainder[c] + i));
      x = hn::Add(from[c], hn::Mul(hn::Set(d, frame.unit), x));
      v = hn::Add(v, widened(d, arrays.v_remainder[c] + i));
    }
    motion.x[c] = x;
    motion.v[c] = v;
  }
  return motion;
}

template <typename T>
HWY_INLINE void load_any(const LeapfrogArrays<T>& arrays, const PositionFrame& frame, std::size_t block, double drift,
                         mesh::VertexLanes& vertices) {
  const D d;
  for (std::size_t l = 0; l < linear::kBlockLanes; l += hn::Lanes(d)) {
    const Motion motion = motion_at(d, arrays, frame, block * linear::kBlockLanes + l);
    for (std::size_t c = 0; c < 3; ++c) {
      hn::Store(motion.x[c], d, &vertices.x[c][l]);
      hn::Store(motion.v[c], d, &vertices.v[c][l]);
      hn::Store(hn::Sub(motion.x[c], hn::Mul(hn::Set(d, drift), motion.v[c])), d, &vertices.before[c][l]);
    }
  }
}

template <typename T>
HWY_INLINE void write_any(const LeapfrogArrays<T>& arrays, const PositionFrame& frame, std::size_t block, double* x,
                          double* v) {
  const D d;
  for (std::size_t l = 0; l < linear::kBlockLanes; l += hn::Lanes(d)) {
    const std::size_t i = block * linear::kBlockLanes + l;
    const Motion motion = motion_at(d, arrays, frame, i);
    hn::StoreInterleaved3(motion.x[0], motion.x[1], motion.x[2], d, x + 3 * i);
    hn::StoreInterleaved3(motion.v[0], motion.v[1], motion.v[2], d, v + 3 * i);
  }
}

// Returns the bits of `changed` for the lanes from l on.
HWY_INLINE hn::Mask<D> mask_at(D d, std::uint32_t changed, std::size_t l) {
  const std::array<std::uint8_t, 8> bits{static_cast<std::uint8_t>(changed >> l),
                                         static_cast<std::uint8_t>(changed >> l >> 8)};
  return hn::LoadMaskBits(d, bits.data());
}

template <typename U>
HWY_INLINE void store_changed(D d, hn::Mask<D> mask, V value, U* to) {
  if constexpr (std::is_same_v<U, double>) {
    hn::Store(hn::IfThenElse(mask, value, hn::Load(d, to)), d, to);
  } else {
    const hn::Rebind<U, D> narrow;
    hn::Store(hn::DemoteTo(narrow, hn::IfThenElse(mask, value, widened(d, to))), narrow, to);
  }
}

template <typename T>
HWY_INLINE void store_corners(const LeapfrogArrays<T>& arrays, std::size_t i) {
  const hn::Rebind<PositionOf<T>, D> d;
  hn::StoreInterleaved4(hn::Load(d, arrays.x[0] + i), hn::Load(d, arrays.x[1] + i), hn::Load(d, arrays.x[2] + i),
                        hn::Zero(d), d, arrays.corner_x + 4 * i);
}

template <typename T>
HWY_INLINE double store_any(const mesh::VertexLanes& vertices, std::uint32_t changed, const PositionFrame& frame,
                            std::size_t block, const LeapfrogArrays<T>& arrays) {
  const D d;
  V largest = hn::Zero(d);
  for (std::size_t l = 0; l < linear::kBlockLanes; l += hn::Lanes(d)) {
    const auto mask = mask_at(d, changed, l);
    if (hn::AllFalse(d, mask)) continue;
    const std::size_t i = block * linear::kBlockLanes + l;
    const std::array<V, 3> from = starts_at(d, frame, i);
    for (std::size_t c = 0; c < 3; ++c) {
      const V x = hn::Load(d, &vertices.x[c][l]);
      const V v = hn::Load(d, &vertices.v[c][l]);
      store_changed(d, mask, v, arrays.v[c] + i);
      if constexpr (std::is_same_v<T, float>) {
        const V all = hn::Mul(hn::Sub(x, from[c]), hn::Set(d, 1.0 / frame.unit));
        const V whole = hn::Round(all);
        largest = hn::Max(largest, hn::IfThenElseZero(mask, hn::Abs(all)));
        store_changed(d, mask, whole, arrays.x[c] + i);
        store_changed(d, mask, hn::Sub(all, whole), arrays.remainder[c] + i);
        store_changed(d, mask, hn::Sub(v, widened(d, arrays.v[c] + i)), arrays.v_remainder[c] + i);
      } else {
        store_changed(d, mask, x, arrays.x[c] + i);
      }
    }
    if (arrays.num_corners[block] > 0) store_corners(arrays, i);
  }
  return hn::GetLane(hn::MaxOfLanes(d, largest));
}

void load_float(const LeapfrogArrays<float>& arrays, const PositionFrame& frame, std::size_t block, double drift,
                mesh::VertexLanes& vertices) {
  load_any(arrays, frame, block, drift, vertices);
}
void load_double(const LeapfrogArrays<double>& arrays, const PositionFrame& frame, std::size_t block, double drift,
                 mesh::VertexLanes& vertices) {
  load_any(arrays, frame, block, drift, vertices);
}
void write_float(const LeapfrogArrays<float>& arrays, const PositionFrame& frame, std::size_t block, double* x,
                 double* v) {
  write_any(arrays, frame, block, x, v);
}
void write_double(const LeapfrogArrays<double>& arrays, const PositionFrame& frame, std::size_t block, double* x,
                  double* v) {
  write_any(arrays, frame, block, x, v);
}
double store_float(const mesh::VertexLanes& vertices, std::uint32_t changed, const PositionFrame& frame,
                   std::size_t block, const LeapfrogArrays<float>& arrays) {
  return store_any(vertices, changed, frame, block, arrays);
}
double store_double(const mesh::VertexLanes& vertices, std::uint32_t changed, const PositionFrame& frame,
                    std::size_t block, const LeapfrogArrays<double>& arrays) {
  return store_any(vertices, changed, frame, block, arrays);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::fem
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::fem {
namespace {
HWY_EXPORT(load_float);
HWY_EXPORT(load_double);
HWY_EXPORT(write_float);
HWY_EXPORT(write_double);
HWY_EXPORT(store_float);
HWY_EXPORT(store_double);
}  // namespace

template <>
void load_vertices(const LeapfrogArrays<float>& arrays, const PositionFrame& frame, std::size_t block, double drift,
                   mesh::VertexLanes& vertices) {
  HWY_DYNAMIC_DISPATCH(load_float)(arrays, frame, block, drift, vertices);
}
template <>
void load_vertices(const LeapfrogArrays<double>& arrays, const PositionFrame& frame, std::size_t block, double drift,
                   mesh::VertexLanes& vertices) {
  HWY_DYNAMIC_DISPATCH(load_double)(arrays, frame, block, drift, vertices);
}
template <>
void write_vertices(const LeapfrogArrays<float>& arrays, const PositionFrame& frame, std::size_t block, double* x,
                    double* v) {
  HWY_DYNAMIC_DISPATCH(write_float)(arrays, frame, block, x, v);
}
template <>
void write_vertices(const LeapfrogArrays<double>& arrays, const PositionFrame& frame, std::size_t block, double* x,
                    double* v) {
  HWY_DYNAMIC_DISPATCH(write_double)(arrays, frame, block, x, v);
}
template <>
double store_vertices(const mesh::VertexLanes& vertices, std::uint32_t changed, const PositionFrame& frame,
                      std::size_t block, const LeapfrogArrays<float>& arrays) {
  return HWY_DYNAMIC_DISPATCH(store_float)(vertices, changed, frame, block, arrays);
}
template <>
double store_vertices(const mesh::VertexLanes& vertices, std::uint32_t changed, const PositionFrame& frame,
                      std::size_t block, const LeapfrogArrays<double>& arrays) {
  return HWY_DYNAMIC_DISPATCH(store_double)(vertices, changed, frame, block, arrays);
}
}  // namespace kerf::fem
#endif  // HWY_ONCE
