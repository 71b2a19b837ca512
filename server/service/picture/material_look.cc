#include "server/service/picture/material_look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

namespace kerf::picture {
namespace {

struct Look {
  std::string_view preset;
  LookNumbers numbers;
  std::uint32_t front = 0;  // sRGB
  std::uint32_t back = 0;
  double threads = 0.0;  // As in render::Finish, from here on.
  double gloss = 0.0;
  double translucency = 0.0;
  double mirror = 0.0;
};

// Colours and numbers are those of the viewer, which web/test/material_looks.test.ts compares.
constexpr std::array<Look, 9> kLooks{{
    {"demo", {4.0e5, 5.0e-4, 400}, 0xebe7da, 0xf0b48b, 1.0, 0.18, 0.0, 0.0},
    {"wool", {3.1e9, 5.0e-4, 1300}, 0x8a7a5c, 0x6d624e, 1.0, 0.0, 0.0, 0.0},
    {"cotton", {4.0e7, 4.0e-4, 375}, 0xb7cbd9, 0xdbe3e8, 0.7, 0.12, 0.2, 0.0},
    {"denim", {5.938e6, 1.066e-3, 304}, 0x2f4a73, 0xa9b4c4, 0.8, 0.05, 0.0, 0.0},
    {"silk", {8.0e7, 1.2e-4, 420}, 0xb23a5b, 0x8e2f52, 0.2, 1.0, 0.25, 0.0},
    {"rubber", {1.5e6, 1.0e-3, 950}, 0x33373c, 0x4a3b36, 0.0, 0.7, 0.0, 0.0},
    {"paper", {5.5e9, 1.0e-4, 800}, 0xf7f9ff, 0xe2e6ef, 0.0, 0.0, 0.35, 0.0},
    {"skin", {5.0e5, 1.5e-3, 1100}, 0xe3b7a0, 0xb8564d, 0.0, 0.4, 0.3, 0.0},
    {"foil", {6.9e10, 1.6e-5, 2710}, 0xc6cbd1, 0xaab0b8, 0.0, 1.0, 0.0, 0.75},
}};
// Colours of the bands of the demo's cloth: indigo in front, brick behind.
constexpr std::uint32_t kFrontDye = 0x1b4c7f;
constexpr std::uint32_t kBackDye = 0xb6472f;

double far(double a, double b) {
  const double ratio = std::log(a / b);
  return ratio * ratio;
}

double distance(const LookNumbers& a, const LookNumbers& b) {
  return far(a.modulus, b.modulus) + far(a.thickness, b.thickness) + far(a.density, b.density);
}

// Dims all colours, because pictures are lit more brightly than the viewer's mesh.
constexpr double kDimmed = 0.83;

render::Colour colour_of(std::uint32_t srgb) {
  const auto channel = [srgb](unsigned shift) {
    return kDimmed * static_cast<double>((srgb >> shift) & 0xffU) / 255.0;
  };
  return {channel(16), channel(8), channel(0)};
}

render::Colour lighter(const render::Colour& colour) {
  const auto half = [](double channel) { return 0.5 + 0.5 * channel; };
  return {half(colour.red), half(colour.green), half(colour.blue)};
}

}  // namespace

render::Look look_of(const LookNumbers& numbers) {
  const Look& nearest = *std::min_element(kLooks.begin(), kLooks.end(), [&numbers](const Look& a, const Look& b) {
    return distance(numbers, a.numbers) < distance(numbers, b.numbers);
  });
  render::Look look;
  look.front = colour_of(nearest.front);
  look.back = colour_of(nearest.back);
  look.lips = lighter(look.front);
  const bool is_gingham = nearest.preset == "demo";
  look.finish = {.bands = is_gingham ? render::Bands::kOfOwnDye : render::Bands::kNone,
                 .front_dye = colour_of(kFrontDye),
                 .back_dye = colour_of(kBackDye),
                 .threads = nearest.threads,
                 .gloss = nearest.gloss,
                 .translucency = nearest.translucency,
                 .mirror = nearest.mirror};
  return look;
}

}  // namespace kerf::picture
