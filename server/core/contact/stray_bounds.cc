#include "server/core/contact/stray_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/contact/stray_bounds.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf::contact {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

HWY_NOINLINE void find_range(const double* x, const double* v, const double* line_x, const double* line_v,
                             std::size_t rows, double since, double ahead, StrayRange& range) {
  const hn::CappedTag<double, 8> d;
  const auto time = hn::Set(d, since + ahead), later = hn::Set(d, ahead);
  for (std::size_t l = 0; l < StrayRange::kRow; l += hn::Lanes(d)) {
    auto sum = hn::Load(d, &range.sum[l]), least = hn::Load(d, &range.least[l]), most = hn::Load(d, &range.most[l]);
    for (std::size_t row = 0; row < rows; ++row) {
      const std::size_t i = row * StrayRange::kRow + l;
      const auto at = hn::Add(hn::LoadU(d, x + i), hn::Mul(later, hn::LoadU(d, v + i)));
      const auto stray = hn::Sub(hn::Sub(at, hn::LoadU(d, line_x + i)), hn::Mul(time, hn::LoadU(d, line_v + i)));
      sum = hn::Add(sum, stray);
      least = hn::Min(least, stray);
      most = hn::Max(most, stray);
    }
    hn::Store(sum, d, &range.sum[l]);
    hn::Store(least, d, &range.least[l]);
    hn::Store(most, d, &range.most[l]);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::contact
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::contact {
namespace {
HWY_EXPORT(find_range);
}  // namespace

Stray find_stray(const linear::VertexField& x, const linear::VertexField& v, const VertexLines& lines, double since,
                 double ahead) {
  StrayRange range;
  range.sum.fill(0.0);
  range.least.fill(std::numeric_limits<double>::infinity());
  range.most.fill(-std::numeric_limits<double>::infinity());
  const auto count = static_cast<std::size_t>(x.size());
  const std::size_t rows = count / StrayRange::kRow;
  HWY_DYNAMIC_DISPATCH(find_range)(x.data(), v.data(), lines.x.data(), lines.v.data(), rows, since, ahead, range);
  for (std::size_t i = rows * StrayRange::kRow; i < count; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double stray = x.data()[k] + ahead * v.data()[k] - lines.x.data()[k] - (since + ahead) * lines.v.data()[k];
    const std::size_t l = i - rows * StrayRange::kRow;
    range.sum[l] += stray;
    range.least[l] = std::min(range.least[l], stray);
    range.most[l] = std::max(range.most[l], stray);
  }
  Stray stray;
  double square = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    double sum = 0.0, least = range.least[c], most = range.most[c];
    for (std::size_t l = c; l < StrayRange::kRow; l += 3) {
      sum += range.sum[l];
      least = std::min(least, range.least[l]);
      most = std::max(most, range.most[l]);
    }
    const double mean = sum / static_cast<double>(std::max<Eigen::Index>(x.cols(), 1));
    stray.mean[static_cast<Eigen::Index>(c)] = mean;
    const double farthest = std::max(most - mean, mean - least);
    square += farthest * farthest;
  }
  stray.most = std::sqrt(square);
  return stray;
}

}  // namespace kerf::contact
#endif  // HWY_ONCE
