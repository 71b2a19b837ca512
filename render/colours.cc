#include "render/colours.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "render/linear.h"

namespace kerf::render {

namespace {

Colour from_hex(unsigned hex) {
  return {(hex >> 16U) / 255.0, ((hex >> 8U) & 0xffU) / 255.0, (hex & 0xffU) / 255.0};
}

Rgb8 to_rgb8(Vec3 light) {
  const auto channel = [](double value) {
    const double srgb = value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1.0 / 2.4) - 0.055;
    return static_cast<std::uint8_t>(std::lround(255.0 * srgb));
  };
  return {channel(light.x), channel(light.y), channel(light.z)};
}

Vec3 mix(Vec3 from, Vec3 to, double share) {
  return (1.0 - share) * from + share * to;
}

constexpr std::array<unsigned, 9> kStops{0x3b4cc0, 0x6282ea, 0x8db0fe, 0xb8d0f9, 0xdddddd,
                                         0xf5c4ad, 0xf49a7b, 0xde604d, 0xb40426};
constexpr std::size_t kNumShades = 1025;  // Entries of the table: neighbours differ by at most one in a channel.
constexpr double kSmallestEnd = 1e-4;     // Smallest strain (-) at which a scale ends.
constexpr double kShareBelow = 0.99;      // Share of the vertices whose strains lie within the scale.
constexpr double kKeepsDownTo = 0.2;      // The scale stays while strains reach this share of its end.

constexpr std::array<unsigned, 7> kPalette{0x0072b2, 0xe69f00, 0x009e73, 0xcc79a7, 0x56b4e9, 0xd55e00, 0xf0e442};
struct Round {
  unsigned towards;
  double share;
};
constexpr std::array<Round, 3> kRounds{{{0xffffff, 0.0}, {0xffffff, 0.5}, {0x000000, 0.4}}};

std::array<Rgb8, kNumShades> make_shades() {
  std::array<Rgb8, kNumShades> shades{};
  constexpr std::size_t kLast = kStops.size() - 1;
  for (std::size_t i = 0; i < kNumShades; ++i) {
    const double at = static_cast<double>(kLast * i) / (kNumShades - 1);
    const std::size_t from = std::min(static_cast<std::size_t>(at), kLast - 1);
    const double share = at - static_cast<double>(from);
    const Colour low = from_hex(kStops[from]);
    const Colour high = from_hex(kStops[from + 1]);
    const auto mixed = [share](double a, double b) {
      return static_cast<std::uint8_t>(std::lround(255.0 * ((1.0 - share) * a + share * b)));
    };
    shades[i] = {mixed(low.red, high.red), mixed(low.green, high.green), mixed(low.blue, high.blue)};
  }
  return shades;
}

// Returns the smallest number >= `value` that is 1, 2 or 5 times a power of ten; `value` > 0.
double rounded_up(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (value <= step * decade * (1.0 + 1e-9)) return step * decade;
  }
  return 10.0 * decade;
}

}  // namespace

Vec3 linear(const Colour& srgb) {
  const auto channel = [](double value) {
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
  };
  return {channel(srgb.red), channel(srgb.green), channel(srgb.blue)};
}

Rgb8 strain_colour(double share) {
  static const std::array<Rgb8, kNumShades> shades = make_shades();
  const double within = std::isnan(share) ? 0.0 : std::clamp(share, -1.0, 1.0);
  return shades[static_cast<std::size_t>(0.5 * (1.0 + within) * (kNumShades - 1) + 0.5)];
}

double strain_scale_end(std::span<const float> strains, double current) {
  double largest = kSmallestEnd;
  std::vector<float> sorted;
  for (const float strain : strains) {
    if (std::isfinite(strain)) sorted.push_back(std::abs(strain));
  }
  if (!sorted.empty()) {
    const auto at = static_cast<std::ptrdiff_t>(kShareBelow * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), sorted.begin() + at, sorted.end());
    largest = std::max(largest, static_cast<double>(sorted[static_cast<std::size_t>(at)]));
  }
  return largest > current || largest < kKeepsDownTo * current ? rounded_up(largest) : current;
}

std::vector<std::uint8_t> strain_colours(std::span<const float> strains, double end) {
  std::vector<std::uint8_t> colours;
  colours.reserve(3 * strains.size());
  for (const float strain : strains) {
    const Rgb8 colour = strain_colour(static_cast<double>(strain) / end);
    colours.insert(colours.end(), colour.begin(), colour.end());
  }
  return colours;
}

Rgb8 piece_colour(std::int64_t id) {
  const auto index = static_cast<std::size_t>(id - 1);
  const Round& round = kRounds[index / kPalette.size() % kRounds.size()];
  return to_rgb8(
      mix(linear(from_hex(kPalette[index % kPalette.size()])), linear(from_hex(round.towards)), round.share));
}

}  // namespace kerf::render
