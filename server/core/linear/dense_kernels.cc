#include "server/core/linear/dense_kernels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/core/linear/lanes16.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/linear/dense_kernels.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf::linear {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

template <typename T>
using Tag = hn::CappedTag<T, kBlockLanes>;

constexpr std::size_t kColumns = 12;  // columns of a panel factored together; a multiple of kTileColumns
constexpr std::size_t kTileColumns = 6;

constexpr std::size_t round_down(std::size_t i) {
  return i / kBlockLanes * kBlockLanes;
}

// Computes C -= A B^T for kVectors vectors of rows and N columns. B has N rows; `stride` is that of A and B.
template <std::size_t kVectors, std::size_t N, typename T>
HWY_INLINE void subtract_tile(const T* A, const T* B, std::size_t stride, std::size_t depth, T* C,
                              std::size_t stride_c) {
  const Tag<T> d;
  using V = hn::Vec<Tag<T>>;
  const std::size_t lanes = hn::Lanes(d);
  std::array<V, kVectors * N> sum;
  sum.fill(hn::Zero(d));
  for (std::size_t t = 0; t < depth; ++t) {
    std::array<V, kVectors> a;
    for (std::size_t m = 0; m < kVectors; ++m) a[m] = hn::LoadU(d, A + m * lanes + t * stride);
    for (std::size_t n = 0; n < N; ++n) {
      const V b = hn::Set(d, B[n + t * stride]);
      for (std::size_t m = 0; m < kVectors; ++m)
        sum[n * kVectors + m] = hn::Add(sum[n * kVectors + m], hn::Mul(a[m], b));
    }
  }
  for (std::size_t n = 0; n < N; ++n) {
    for (std::size_t m = 0; m < kVectors; ++m) {
      T* const c = C + m * lanes + n * stride_c;
      hn::StoreU(hn::Sub(hn::LoadU(d, c), sum[n * kVectors + m]), d, c);
    }
  }
}

// Computes C -= A B^T for `rows`, rounded up to whole vectors.
template <std::size_t N, typename T>
HWY_INLINE void subtract_columns(const T* A, const T* B, std::size_t stride, std::size_t depth, std::size_t rows, T* C,
                                 std::size_t stride_c) {
  const std::size_t lanes = hn::Lanes(Tag<T>());
  std::size_t r = 0;
  for (; r + lanes < rows; r += 2 * lanes) subtract_tile<2, N>(A + r, B, stride, depth, C + r, stride_c);
  if (r < rows) subtract_tile<1, N>(A + r, B, stride, depth, C + r, stride_c);
}

// Subtracts the contributions of earlier columns from columns [first, first + width) of the panel.
template <typename T>
HWY_INLINE void subtract_columns_before(const PanelView<T>& panel, std::size_t first, std::size_t width) {
  std::size_t c = first;
  const auto subtract = [&]<std::size_t N>() {
    const std::size_t top = round_down(c);
    subtract_columns<N>(panel.entries + top, panel.entries + c, panel.stride, first, panel.rows - top,
                        panel.entries + top + c * panel.stride, panel.stride);
    c += N;
  };
  while (c + kTileColumns <= first + width) subtract.template operator()<kTileColumns>();
  if (c < first + width) subtract.template operator()<3>();
}

// Solves X = A L^-T in rows [top, rows) of columns [first, first + N). L, by columns, has reciprocals on its diagonal.
template <std::size_t N, typename T>
HWY_INLINE void solve_rows(const PanelView<T>& panel, std::size_t first, const T* L, std::size_t top) {
  const Tag<T> d;
  using V = hn::Vec<Tag<T>>;
  for (std::size_t r = top; r < panel.rows; r += hn::Lanes(d)) {
    std::array<V, N> x;
    for (std::size_t j = 0; j < N; ++j) {
      x[j] = hn::Load(d, panel.entries + r + (first + j) * panel.stride);
      for (std::size_t t = 0; t < j; ++t) x[j] = hn::Sub(x[j], hn::Mul(x[t], hn::Set(d, L[j + t * N])));
      x[j] = hn::Mul(x[j], hn::Set(d, L[j + j * N]));
    }
    for (std::size_t j = 0; j < N; ++j) hn::Store(x[j], d, panel.entries + r + (first + j) * panel.stride);
  }
}

// Factors columns [first, first + N), after the contributions of earlier columns have been subtracted.
template <std::size_t N, typename T>
HWY_INLINE bool factor_columns(const PanelView<T>& panel, std::size_t first, const T* diagonal, PivotRule<T>& rule) {
  std::array<T, N * N> L{};
  std::array<T, N> pivot{};
  for (std::size_t j = 0; j < N; ++j) {
    for (std::size_t i = j; i < N; ++i) {
      T value = panel.entries[first + i + (first + j) * panel.stride];
      for (std::size_t t = 0; t < j; ++t) value -= L[i + t * N] * L[j + t * N];
      if (i > j) {
        L[i + j * N] = value * L[j + j * N];
        continue;
      }
      if (!(value > rule.least * diagonal[first + j])) {
        if (!rule.replaces || !(diagonal[first + j] > 0) || !std::isfinite(value)) return false;
        value = std::max(diagonal[first + j], std::abs(value));
        ++rule.replaced;
      }
      pivot[j] = std::sqrt(value);
      L[j + j * N] = 1 / pivot[j];
    }
  }
  solve_rows<N>(panel, first, L.data(), round_down(first));
  for (std::size_t j = 0; j < N; ++j) {
    T* const column = panel.entries + first + (first + j) * panel.stride;
    column[j] = pivot[j];
    for (std::size_t i = j + 1; i < N; ++i) column[i] = L[i + j * N];
  }
  return true;
}

template <typename T>
bool factor(const PanelView<T>& panel, const T* diagonal, PivotRule<T>& rule) {
  for (std::size_t first = 0; first < panel.width; first += kColumns) {
    const std::size_t width = std::min(kColumns, panel.width - first);
    if (first > 0) subtract_columns_before(panel, first, width);
    bool done = false;
    switch (width) {
      case 3:
        done = factor_columns<3>(panel, first, diagonal, rule);
        break;
      case 6:
        done = factor_columns<6>(panel, first, diagonal, rule);
        break;
      case 9:
        done = factor_columns<9>(panel, first, diagonal, rule);
        break;
      default:
        done = factor_columns<kColumns>(panel, first, diagonal, rule);
    }
    if (!done) return false;
  }
  return true;
}

template <typename T>
void subtract_outer(const PanelView<T>& panel, const PanelView<T>& update) {
  const T* const below = panel.entries + panel.width;
  std::size_t c = 0;
  const auto subtract = [&]<std::size_t N>() {
    const std::size_t top = round_down(c);
    subtract_columns<N>(below + top, below + c, panel.stride, panel.width, update.rows - top,
                        update.entries + top + c * update.stride, update.stride);
    c += N;
  };
  while (c + kTileColumns <= update.rows) subtract.template operator()<kTileColumns>();
  if (c < update.rows) subtract.template operator()<3>();
}

template <typename T>
void forward(const PanelView<const T>& panel, T* w) {
  const Tag<T> d;
  for (std::size_t t = 0; t < panel.width; ++t) {
    const T* const column = panel.entries + t * panel.stride;
    w[t] /= column[t];
    const auto y = hn::Set(d, w[t]);
    for (std::size_t r = t + 1; r < panel.rows; r += hn::Lanes(d)) {
      hn::StoreU(hn::Sub(hn::LoadU(d, w + r), hn::Mul(y, hn::LoadU(d, column + r))), d, w + r);
    }
  }
}

template <typename T>
T dot(const T* a, const T* b, std::size_t size) {
  const Tag<T> d;
  constexpr std::size_t kVectors = kBlockLanes / hn::MaxLanes(Tag<T>());
  const std::size_t lanes = hn::Lanes(d);
  std::array<hn::Vec<Tag<T>>, kVectors> sum;
  sum.fill(hn::Zero(d));
  std::size_t i = 0;
  for (; i + kBlockLanes <= size; i += kBlockLanes) {
    for (std::size_t m = 0; m < kVectors; ++m) {
      const std::size_t at = i + m * lanes;
      sum[m] = hn::Add(sum[m], hn::Mul(hn::LoadU(d, a + at), hn::LoadU(d, b + at)));
    }
  }
  Lanes16<T> partial;
  for (std::size_t m = 0; m < kVectors; ++m) hn::Store(sum[m], d, partial.lane.data() + m * lanes);
  for (std::size_t l = 0; i < size; ++i, ++l) partial.lane[l] += a[i] * b[i];
  for (std::size_t half = kBlockLanes / 2; half > 0; half /= 2) {
    for (std::size_t l = 0; l < half; ++l) partial.lane[l] += partial.lane[l + half];
  }
  return partial.lane[0];
}

template <typename T>
void backward(const PanelView<const T>& panel, T* w) {
  for (std::size_t t = panel.width; t-- > 0;) {
    const T* const column = panel.entries + t * panel.stride;
    w[t] = (w[t] - dot(column + t + 1, w + t + 1, panel.rows - t - 1)) / column[t];
  }
}

bool factor_float(const PanelView<float>& panel, const float* diagonal, PivotRule<float>& rule) {
  return factor(panel, diagonal, rule);
}
bool factor_double(const PanelView<double>& panel, const double* diagonal, PivotRule<double>& rule) {
  return factor(panel, diagonal, rule);
}
void outer_float(const PanelView<float>& panel, const PanelView<float>& update) {
  subtract_outer(panel, update);
}
void outer_double(const PanelView<double>& panel, const PanelView<double>& update) {
  subtract_outer(panel, update);
}
void forward_float(const PanelView<const float>& panel, float* w) {
  forward(panel, w);
}
void forward_double(const PanelView<const double>& panel, double* w) {
  forward(panel, w);
}
void backward_float(const PanelView<const float>& panel, float* w) {
  backward(panel, w);
}
void backward_double(const PanelView<const double>& panel, double* w) {
  backward(panel, w);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::linear
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::linear {
namespace {
HWY_EXPORT(factor_float);
HWY_EXPORT(factor_double);
HWY_EXPORT(outer_float);
HWY_EXPORT(outer_double);
HWY_EXPORT(forward_float);
HWY_EXPORT(forward_double);
HWY_EXPORT(backward_float);
HWY_EXPORT(backward_double);
}  // namespace

template <>
bool factor_panel(const PanelView<float>& panel, const float* diagonal, PivotRule<float>& rule) {
  return HWY_DYNAMIC_DISPATCH(factor_float)(panel, diagonal, rule);
}
template <>
bool factor_panel(const PanelView<double>& panel, const double* diagonal, PivotRule<double>& rule) {
  return HWY_DYNAMIC_DISPATCH(factor_double)(panel, diagonal, rule);
}
template <>
void subtract_outer_product(const PanelView<float>& panel, const PanelView<float>& update) {
  HWY_DYNAMIC_DISPATCH(outer_float)(panel, update);
}
template <>
void subtract_outer_product(const PanelView<double>& panel, const PanelView<double>& update) {
  HWY_DYNAMIC_DISPATCH(outer_double)(panel, update);
}
template <>
void substitute_forward(const PanelView<const float>& panel, float* w) {
  HWY_DYNAMIC_DISPATCH(forward_float)(panel, w);
}
template <>
void substitute_forward(const PanelView<const double>& panel, double* w) {
  HWY_DYNAMIC_DISPATCH(forward_double)(panel, w);
}
template <>
void substitute_backward(const PanelView<const float>& panel, float* w) {
  HWY_DYNAMIC_DISPATCH(backward_float)(panel, w);
}
template <>
void substitute_backward(const PanelView<const double>& panel, double* w) {
  HWY_DYNAMIC_DISPATCH(backward_double)(panel, w);
}
}  // namespace kerf::linear
#endif  // HWY_ONCE
