#include "server/service/wire/quantise.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/base/check.h"

namespace kerf::wire {
namespace {

constexpr double kSteps = 65535.0;
constexpr double kRoom = 1.25;  // -; box size over the sheet's extent, before rounding up.
constexpr double kSmallestSizeM = 0x1p-10;
// -; a box is replaced if a side is more than this many times that of a fresh box.
constexpr double kShrinkRatio = 8.0;
// Smallest box size relative to the distance from the origin. It keeps the corner, a multiple of size / 16, and corner
// + size exact far from the origin.
constexpr double kSmallestRelativeSize = 0x1p-40;

constexpr double kSmallestStrainScale = 0x1p-20;
constexpr double kLargestStrainScale = 0x1p10;

struct Extent {
  std::array<double, 3> low{};
  std::array<double, 3> high{};
};

Extent extent_of(std::span<const double> positions) {
  Extent extent;
  if (positions.empty()) return extent;
  for (std::size_t axis = 0; axis < 3; ++axis) extent.low[axis] = extent.high[axis] = positions[axis];
  for (std::size_t i = 3; i + 2 < positions.size(); i += 3) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      extent.low[axis] = std::min(extent.low[axis], positions[i + axis]);
      extent.high[axis] = std::max(extent.high[axis], positions[i + axis]);
    }
  }
  return extent;
}

double power_of_two_at_least(double value) {
  int exponent = 0;
  const double mantissa = std::frexp(value, &exponent);  // value = mantissa * 2^exponent, mantissa in [0.5, 1)
  return std::ldexp(1.0, mantissa == 0.5 ? exponent - 1 : exponent);
}

FrameBox fresh_box(const Extent& extent) {
  double largest = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) largest = std::max(largest, extent.high[axis] - extent.low[axis]);
  FrameBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = extent.low[axis];
    const double high = extent.high[axis];
    const double farthest = std::max(std::abs(low), std::abs(high));
    const double wanted =
        std::max({kRoom * (high - low), 0.25 * kRoom * largest, kSmallestSizeM, kSmallestRelativeSize * farthest});
    const double size = power_of_two_at_least(wanted);
    const double step = size / 16.0;
    box.size[axis] = size;
    box.min[axis] = std::floor((0.5 * (low + high) - 0.5 * size) / step + 0.5) * step;
  }
  return box;
}

bool still_fits(const FrameBox& box, const FrameBox& fresh, const Extent& extent) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (extent.low[axis] < box.min[axis] || extent.high[axis] > box.min[axis] + box.size[axis]) return false;
    if (box.size[axis] > kShrinkRatio * fresh.size[axis]) return false;
  }
  return true;
}

}  // namespace

FrameBox choose_box(std::span<const double> positions, const std::optional<FrameBox>& current) {
  const Extent extent = extent_of(positions);
  const FrameBox fresh = fresh_box(extent);
  return current && still_fits(*current, fresh, extent) ? *current : fresh;
}

std::vector<std::uint16_t> quantise(std::span<const double> positions, const FrameBox& box) {
  std::vector<std::uint16_t> quantised(positions.size());
  const std::array<double, 3> scale{kSteps / box.size[0], kSteps / box.size[1], kSteps / box.size[2]};
  for (std::size_t i = 0; i + 2 < positions.size(); i += 3) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double q = (positions[i + axis] - box.min[axis]) * scale[axis] + 0.5;
      KERF_DCHECK(q >= 0.5 && q < kSteps + 1.0, "a position outside the box it is quantised in");
      quantised[i + axis] = static_cast<std::uint16_t>(q);  // q > 0: truncation is floor
    }
  }
  return quantised;
}

QuantisedStrains quantise_strains(std::span<const float> strains) {
  double largest = kSmallestStrainScale;
  for (const float strain : strains) {
    if (std::isfinite(strain)) largest = std::max(largest, std::abs(static_cast<double>(strain)));
  }
  QuantisedStrains quantised;
  quantised.scale = power_of_two_at_least(std::min(largest, kLargestStrainScale));
  quantised.values.reserve(strains.size());
  for (const float strain : strains) {
    const double share =
        std::isfinite(strain) ? std::clamp(static_cast<double>(strain) / quantised.scale, -1.0, 1.0) : 0.0;
    quantised.values.push_back(
        static_cast<std::int8_t>(std::lround(std::copysign(127.0 * std::sqrt(std::abs(share)), share))));
  }
  return quantised;
}

}  // namespace kerf::wire
