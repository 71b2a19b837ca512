#include "server/core/linear/dense_fours.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/linear/dense_fours.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "server/core/linear/fours-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kerf::linear {
namespace HWY_NAMESPACE {
namespace {

// Returns from[0] to from[3], repeated over the lanes. A vector of fewer than four lanes starts at from[part].
template <class D>
HWY_INLINE hn::Vec<D> load_repeated(D d, const hn::TFromD<D>* from, std::size_t part) {
  if constexpr (hn::MaxLanes(D()) <= 4) {
    return hn::LoadU(d, from + part);
  } else if constexpr (std::is_same_v<hn::TFromD<D>, float>) {
    return hn::LoadDup128(d, from);
  } else {
    const auto half = load_repeated(hn::Half<D>(), from, part);
    return joined(d, half, half);
  }
}

template <typename T>
HWY_INLINE void multiply_any(const DenseFours<T>& matrix, const T* from, T* to) {
  const Fours<T> d;
  const std::size_t num_fours = matrix.num_fours();
  for (std::size_t four = 0; four < num_fours; ++four) {
    for (std::size_t part = 0; part < 16; part += hn::Lanes(d)) {
      auto sum = hn::Zero(d);
      for (std::size_t j = 0; j < matrix.size; ++j) {
        const auto value = spread(d, matrix.entries[j * num_fours + four], part / 4);
        sum = hn::Add(sum, hn::Mul(value, load_repeated(d, from + 4 * j, part % 4)));
      }
      hn::StoreU(sum, d, to + 16 * four + part);
    }
  }
}

void multiply_float(const DenseFours<float>& matrix, const float* from, float* to) {
  multiply_any(matrix, from, to);
}
void multiply_double(const DenseFours<double>& matrix, const double* from, double* to) {
  multiply_any(matrix, from, to);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::linear
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::linear {
namespace {
HWY_EXPORT(multiply_float);
HWY_EXPORT(multiply_double);
}  // namespace

template <>
void multiply(const DenseFours<float>& matrix, const float* from, float* to) {
  HWY_DYNAMIC_DISPATCH(multiply_float)(matrix, from, to);
}
template <>
void multiply(const DenseFours<double>& matrix, const double* from, double* to) {
  HWY_DYNAMIC_DISPATCH(multiply_double)(matrix, from, to);
}
}  // namespace kerf::linear
#endif  // HWY_ONCE
