#include "render/ground.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "render/linear.h"
#include "render/sky_light.h"

namespace kerf::render {

namespace {

constexpr double kThingsWithin = 0.25;           // Things stand within this share of the disc's radius.
constexpr float kSkyShare = 0.75F;               // Share of the ground's light that comes from the sky.
constexpr std::size_t kPoints = SkyLight::kRow;  // Points of the ground's grid along a side.

// Returns the places of the grid's points along a side, in [-1, 1] radii. They are closer together in the middle, where
// things stand.
std::array<double, kPoints> spacing() {
  std::array<double, kPoints> places{};
  for (std::size_t i = 0; i < kPoints; ++i) {
    const double t = 2.0 * static_cast<double>(i) / (kPoints - 1) - 1.0;
    places[i] = 0.35 * t + 0.65 * t * t * t;
  }
  return places;
}

SurfaceVertex ground_vertex(const PlaneFrame& frame, double radius, double u, double v, float taken) {
  const Vec3 place = frame.origin + (radius * u) * frame.right + (radius * v) * frame.up;
  const auto light = static_cast<std::uint8_t>(std::lround(128.0F * (1.0F - kSkyShare * taken * std::sqrt(taken))));
  return {{static_cast<float>(place.x), static_cast<float>(place.y), static_cast<float>(place.z)},
          {static_cast<float>(frame.normal.x), static_cast<float>(frame.normal.y), static_cast<float>(frame.normal.z)},
          {static_cast<float>(u), static_cast<float>(v)},
          {light, light, light, 128}};
}

void append_squares(const PlaneFrame& frame, double radius, DrawList& list) {
  SkyLight sky(frame, kThingsWithin * radius);
  sky.add(list.sheet, 1.0);
  sky.add(list.solids, 0.5);
  const std::array<double, kPoints> places = spacing();
  std::array<float, kPoints> x{};
  std::ranges::transform(places, x.begin(), [radius](double place) { return static_cast<float>(radius * place); });
  std::vector<SurfaceVertex> points;
  points.reserve(kPoints * kPoints);
  for (std::size_t j = 0; j < kPoints; ++j) {
    const std::array<float, kPoints> taken = sky.occlusion(x, x[j]);
    for (std::size_t i = 0; i < kPoints; ++i) {
      points.push_back(ground_vertex(frame, radius, places[i], places[j], taken[i]));
    }
  }
  for (std::size_t j = 0; j + 1 < kPoints; ++j) {
    for (std::size_t i = 0; i + 1 < kPoints; ++i) {
      const std::size_t a = j * kPoints + i;
      for (const std::size_t corner : {a, a + 1, a + kPoints + 1, a, a + kPoints + 1, a + kPoints}) {
        list.ground.push_back(points[corner]);
      }
    }
  }
}

}  // namespace

void append_ground(const Plane& plane, Vec3 near, double radius, bool sky_light, DrawList& list) {
  const Vec3 normal = normalized(plane.normal);
  const Vec3 right = perpendicular(normal);
  const PlaneFrame frame{near - dot(near - plane.point, normal) * normal, right, cross(normal, right), normal};
  if (sky_light) return append_squares(frame, radius, list);
  for (const auto& [u, v] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}}) {
    list.ground.push_back(ground_vertex(frame, radius, u, v, 0.0F));
  }
}

}  // namespace kerf::render
