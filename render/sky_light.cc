#include "render/sky_light.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace kerf::render {

namespace {

Vec3 to_vec3(const std::array<float, 3>& v) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

}  // namespace

SkyLight::SkyLight(const PlaneFrame& frame, double reach)
    : frame_(frame), reach_(reach), cells_(kCells * kCells * kCells) {}

std::size_t SkyLight::cell_of(Vec3 place) const {
  const auto along = [this](double from_border) {
    const double cell = from_border / (2.0 * reach_) * static_cast<double>(kCells);
    return static_cast<std::size_t>(std::clamp(cell, 0.0, static_cast<double>(kCells - 1)));
  };
  return (along(place.z) * kCells + along(place.y + reach_)) * kCells + along(place.x + reach_);
}

void SkyLight::add(const std::vector<SurfaceVertex>& triangles, double weight) {
  const auto in_frame = [this](Vec3 v) { return Vec3{dot(v, frame_.right), dot(v, frame_.up), dot(v, frame_.normal)}; };
  for (std::size_t i = 0; i + 2 < triangles.size(); i += 3) {
    const Vec3 a = to_vec3(triangles[i].position);
    const Vec3 u = to_vec3(triangles[i + 1].position) - a;
    const Vec3 v = to_vec3(triangles[i + 2].position) - a;
    const Vec3 place = in_frame(a + (1.0 / 3.0) * (u + v) - frame_.origin);
    if (place.z < 0.0) continue;
    const Vec3 area = 0.5 * weight * in_frame(cross(u, v));
    const double size = norm(area);
    Cell& cell = cells_[cell_of(place)];
    cell.area = dot(cell.area, area) < 0.0 ? cell.area - area : cell.area + area;
    cell.moment = cell.moment + size * place;
    cell.size += size;
  }
}

std::array<float, SkyLight::kRow> SkyLight::occlusion(const std::array<float, kRow>& x, float y) const {
  std::array<float, kRow> sums{};
  const double nearest = 2.0 * reach_ / kCells;
  for (const Cell& cell : cells_) {
    if (!(cell.size > 0.0)) continue;
    const Vec3 place = (1.0 / cell.size) * cell.moment;
    const auto height = static_cast<float>(std::max(place.z, nearest));
    const auto to_x = static_cast<float>(place.x);
    const float dy = static_cast<float>(place.y) - y;
    const auto area_x = static_cast<float>(cell.area.x);
    const float area_yz = static_cast<float>(cell.area.y) * dy + static_cast<float>(cell.area.z) * height;
    const float square_yz = dy * dy + height * height;
    const float scale = height / std::numbers::pi_v<float>;
    // The loop has a fixed length, so that it can be vectorised.
    for (std::size_t i = 0; i < kRow; ++i) {
      const float dx = to_x - x[i];
      const float square = dx * dx + square_yz;
      sums[i] += scale * std::abs(area_x * dx + area_yz) / (square * square);
    }
  }
  std::ranges::transform(sums, sums.begin(), [](float sum) { return 1.0F - std::exp(-sum); });
  return sums;
}

}  // namespace kerf::render
