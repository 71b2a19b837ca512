#pragma once

#include <array>
#include <cmath>

#include "render/colours.h"
#include "render/linear.h"

// Measures the visible difference of colours.
namespace kerf::render::testing {

inline Vec3 light_of(Rgb8 colour) {
  return linear({colour[0] / 255.0, colour[1] / 255.0, colour[2] / 255.0});
}

// CIELAB (L* in [0, 100], a*, b*) of a colour under D65.
inline std::array<double, 3> lab(Vec3 light) {
  const auto f = [](double t) { return t > 216.0 / 24389.0 ? std::cbrt(t) : (24389.0 / 27.0 * t + 16.0) / 116.0; };
  const double x = f((0.4124564 * light.x + 0.3575761 * light.y + 0.1804375 * light.z) / 0.95047);
  const double y = f(0.2126729 * light.x + 0.7151522 * light.y + 0.0721750 * light.z);
  const double z = f((0.0193339 * light.x + 0.1191920 * light.y + 0.9503041 * light.z) / 1.08883);
  return {116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)};
}

// CIE 1976; 2.3 is just noticed.
inline double distance_of(Vec3 a, Vec3 b) {
  const auto p = lab(a);
  const auto q = lab(b);
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}
inline double distance_of(Rgb8 a, Rgb8 b) {
  return distance_of(light_of(a), light_of(b));
}

enum class Cone { kNone, kLong, kMiddle };

// Returns the colour as seen without that kind of cone, in linear light. F. Viénot, H. Brettel, J. D. Mollon, "Digital
// video colourmaps for checking the legibility of displays by dichromats" (1999), where red and green become one.
inline Vec3 as_seen_without(Cone cone, Rgb8 colour) {
  const Vec3 light = light_of(colour);
  if (cone == Cone::kNone) return light;
  const bool no_red = cone == Cone::kLong;
  const double yellow = no_red ? 0.11238 * light.x + 0.88762 * light.y : 0.29275 * light.x + 0.70725 * light.y;
  const double blue = (no_red ? 0.00401 : -0.02234) * (light.x - light.y) + light.z;
  return {yellow, yellow, std::fmin(std::fmax(blue, 0.0), 1.0)};
}

}  // namespace kerf::render::testing
