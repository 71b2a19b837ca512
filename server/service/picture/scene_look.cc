#include "server/service/picture/scene_look.h"

#include <numbers>

#include "render/colours.h"

namespace kerf::picture {
namespace {

// The viewer has the same numbers, which web/test/surroundings.test.ts compares.
struct Surroundings {
  unsigned sky_top;
  unsigned sky_bottom;
  unsigned ground;
  unsigned ground_lines;
  unsigned light_below;
  double sky_intensity;
};
constexpr Surroundings kLightTheme{0xfbfcfd, 0xd6dde6, 0xe6eaef, 0x5b6675, 0x9a948c, 1.25};
constexpr Surroundings kDarkTheme{0x262e3a, 0x0d1117, 0x2a303a, 0x8794a8, 0x3a4250, 0.9};
constexpr unsigned kSolids = 0x9aa3ad;
constexpr unsigned kSun = 0xfff9f1;
constexpr double kSunIntensity = 2.3;
constexpr render::Vec3 kTowardsSun{-0.45, -0.5, 1.0};

// Returns light of this intensity as a white surface reflects it.
render::Vec3 reflected(unsigned srgb, double intensity) {
  const render::Vec3 light = render::linear(from_hex(srgb));
  const double share = intensity / std::numbers::pi;
  return {share * light.x, share * light.y, share * light.z};
}

}  // namespace

render::Colour from_hex(unsigned srgb) {
  const auto channel = [srgb](unsigned shift) { return static_cast<double>((srgb >> shift) & 0xffU) / 255.0; };
  return {channel(16), channel(8), channel(0)};
}

void set_surroundings(bool is_dark, render::Style& style) {
  const Surroundings& theme = is_dark ? kDarkTheme : kLightTheme;
  style.background = from_hex(theme.sky_top);
  style.background_below = from_hex(theme.sky_bottom);
  style.ground = from_hex(theme.ground);
  style.ground_lines = from_hex(theme.ground_lines);
  style.solids = from_hex(kSolids);
  style.light.sky = reflected(0xffffff, theme.sky_intensity);
  style.light.below = reflected(theme.light_below, theme.sky_intensity);
  style.light.key = reflected(kSun, kSunIntensity);
  style.light.towards_key = kTowardsSun;
}

}  // namespace kerf::picture
