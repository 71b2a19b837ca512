#include "server/service/dxf/colours.h"

#include <algorithm>
#include <array>

namespace kerf::dxf {
namespace {

std::uint32_t channel_of(double share) {
  return static_cast<std::uint32_t>(255.0 * std::clamp(share, 0.0, 1.0));
}

}  // namespace

std::uint32_t indexed_colour(int index) {
  constexpr std::array<std::uint32_t, 10> kFirst{0x000000, 0xff0000, 0xffff00, 0x00ff00, 0x00ffff,
                                                 0x0000ff, 0xff00ff, 0x000000, 0x808080, 0xc0c0c0};
  constexpr std::array<std::uint32_t, 6> kGreys{0x333333, 0x505050, 0x696969, 0x828282, 0xbebebe, 0xffffff};
  constexpr std::array<double, 5> kValues{1.0, 0.65, 0.5, 0.3, 0.15};
  if (index < 10) return kFirst[static_cast<std::size_t>(std::max(index, 0))];
  if (index >= 250) return kGreys[static_cast<std::size_t>(std::min(index, 255) - 250)];
  // 24 hues, each with five values, pure and mixed with white.
  const double hue = static_cast<double>(index / 10 - 1) / 4.0;  // Sixths of the circle.
  const double value = kValues[static_cast<std::size_t>(index % 10 / 2)];
  const double least = index % 2 == 0 ? 0.0 : 0.5;
  const auto share = [&](double shift) {
    double at = hue + shift;
    while (at >= 6.0) at -= 6.0;
    const double pure = std::clamp(std::min(at, 4.0 - at), 0.0, 1.0);
    return channel_of(value * (least + (1.0 - least) * pure));
  };
  return share(2.0) << 16U | share(0.0) << 8U | share(4.0);
}

}  // namespace kerf::dxf
