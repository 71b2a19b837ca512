#include "server/service/picture/material_look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "server/service/picture/scene_look.h"

namespace kerf::picture {
namespace {

using enum render::Pattern;

struct Look {
  std::string_view preset;
  LookNumbers numbers;
  unsigned front = 0;  // sRGB
  unsigned back = 0;
  unsigned second = 0;
  render::Pattern pattern = kWeave;
  double contrast = 0.0;  // As in render::Finish, from here on.
  double grid = 0.0;
  double roughness = 0.0;
  double sheen = 0.0;
  double translucency = 0.0;
  double mirror = 0.0;
};

// Colours and numbers are those of the viewer, which web/test/material_looks.test.ts compares.
constexpr std::array<Look, 9> kLooks{{
    {"demo", {4.0e5, 5.0e-4, 400}, 0xebe7da, 0xf0b48b, 0xffffff, kGingham, 0.1, 0.14, 0.86, 0.0, 0.0, 0.0},
    {"wool", {3.1e9, 5.0e-4, 1300}, 0x8a7a5c, 0x6d624e, 0xffffff, kKnit, 0.34, 0.14, 1.0, 0.22, 0.0, 0.0},
    {"cotton", {4.0e7, 4.0e-4, 375}, 0xb7cbd9, 0xdbe3e8, 0xffffff, kWeave, 0.16, 0.14, 0.86, 0.0, 0.2, 0.0},
    {"denim", {5.938e6, 1.066e-3, 304}, 0x2f4a73, 0xa9b4c4, 0xc9d2de, kTwill, 0.3, 0.14, 0.95, 0.0, 0.0, 0.0},
    {"silk", {8.0e7, 1.2e-4, 420}, 0xb23a5b, 0x8e2f52, 0xffffff, kWeave, 0.04, 0.08, 0.34, 0.5, 0.25, 0.0},
    {"rubber", {1.5e6, 1.0e-3, 950}, 0x33373c, 0x4a3b36, 0xffffff, kGrain, 0.05, -0.35, 0.42, 0.0, 0.0, 0.0},
    {"paper", {5.5e9, 1.0e-4, 800}, 0xf7f9ff, 0xe2e6ef, 0xffffff, kGrain, 0.05, 0.16, 0.97, 0.0, 0.35, 0.0},
    {"skin", {5.0e5, 1.5e-3, 1100}, 0xe3b7a0, 0xb8564d, 0xffffff, kGrain, 0.1, 0.1, 0.55, 0.12, 0.3, 0.0},
    {"foil", {6.9e10, 1.6e-5, 2710}, 0xc6cbd1, 0xaab0b8, 0xffffff, kGrain, 0.03, 0.1, 0.25, 0.0, 0.0, 0.75},
}};
// Colours of the bands of the demo's cloth: indigo in front, brick behind.
constexpr unsigned kFrontDye = 0x1b4c7f;
constexpr unsigned kBackDye = 0xb6472f;

double far(double a, double b) {
  const double ratio = std::log(a / b);
  return ratio * ratio;
}

double distance(const LookNumbers& a, const LookNumbers& b) {
  return far(a.modulus, b.modulus) + far(a.thickness, b.thickness) + far(a.density, b.density);
}

}  // namespace

render::Look look_of(const LookNumbers& numbers) {
  const Look& nearest = *std::min_element(kLooks.begin(), kLooks.end(), [&numbers](const Look& a, const Look& b) {
    return distance(numbers, a.numbers) < distance(numbers, b.numbers);
  });
  render::Look look;
  look.front = from_hex(nearest.front);
  look.back = from_hex(nearest.back);
  look.lips = look.front;
  look.finish = {.pattern = nearest.pattern,
                 .front_dye = from_hex(kFrontDye),
                 .back_dye = from_hex(kBackDye),
                 .second = from_hex(nearest.second),
                 .contrast = nearest.contrast,
                 .grid = nearest.grid,
                 .roughness = nearest.roughness,
                 .sheen = nearest.sheen,
                 .translucency = nearest.translucency,
                 .mirror = nearest.mirror};
  return look;
}

}  // namespace kerf::picture
