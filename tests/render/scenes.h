#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "render/renderer.h"
#include "render/views.h"

namespace kerf::render::testing {

// A sheet that owns its arrays.
struct Sheet {
  std::vector<float> positions;
  std::vector<float> material;
  std::vector<std::int32_t> triangles;
  std::vector<std::int32_t> pieces;
  std::vector<std::uint8_t> colours;

  [[nodiscard]] Mesh mesh() const {
    Mesh mesh;
    mesh.positions = positions;
    mesh.material_coordinates = material;
    mesh.triangles = triangles;
    mesh.piece_ids = pieces;
    mesh.vertex_colours = colours;
    mesh.material_upper = {1.0F, 1.0F};
    return mesh;
  }
};

// Selects the state of the sheet's middle column of vertices in the rows strictly between a quarter and three quarters.
enum class Slit {
  kNone,    // a whole sheet
  kClosed,  // two vertices at each place: a cut that has not opened
  kOpen,    // 0.1 m apart: a hole in the shape of a lens
};

// 1 m x 1 m, n x n cells (n divisible by 4), upright, facing -y and bulging that way by `bulge` (m): the corner (0, 0)
// of material space is at x = -0.5, z = -0.5. Triangles are counter-clockwise seen from -y.
inline Sheet make_sheet(int n, double bulge, Slit slit = Slit::kNone) {
  Sheet sheet;
  std::vector<std::int32_t> twin(static_cast<std::size_t>((n + 1) * (n + 1)), -1);
  const auto add = [&](int i, int j, double shift) {
    const double u = static_cast<double>(i) / n;
    const double v = static_cast<double>(j) / n;
    const double y = -bulge * 4.0 * u * (1.0 - u);
    for (const double p : {u - 0.5 + shift, y, v - 0.5}) sheet.positions.push_back(static_cast<float>(p));
    for (const double p : {u, v}) sheet.material.push_back(static_cast<float>(p));
    return static_cast<std::int32_t>(sheet.positions.size() / 3 - 1);
  };
  const auto on_slit = [n, slit](int i, int j) {
    return slit != Slit::kNone && 2 * i == n && 4 * j > n && 4 * j < 3 * n;
  };
  const double half_gap = slit == Slit::kOpen ? 0.05 : 0.0;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) add(i, j, on_slit(i, j) ? -half_gap : 0.0);
  }
  for (int j = 0; j <= n; ++j) {
    if (on_slit(n / 2, j)) twin[static_cast<std::size_t>(j * (n + 1) + n / 2)] = add(n / 2, j, half_gap);
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i;
      for (const int vertex : {a, a + 1, a + n + 2, a, a + n + 2, a + n + 1}) {
        const std::int32_t right = twin[static_cast<std::size_t>(vertex)];
        sheet.triangles.push_back(2 * i >= n && right >= 0 ? right : vertex);
      }
    }
  }
  return sheet;
}

// Before the sheet, looking along +y.
inline Camera front_camera() {
  Camera camera;
  camera.eye = {0.0, -2.0, 0.0};
  camera.target = {0.0, 0.0, 0.0};
  return camera;
}

struct Rgb {
  int red;
  int green;
  int blue;
  friend bool operator==(const Rgb&, const Rgb&) = default;
};

inline Rgb pixel(const Pixels& pixels, int x, int y) {
  const std::size_t at =
      4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(pixels.width) + static_cast<std::size_t>(x));
  return {pixels.rgba[at], pixels.rgba[at + 1], pixels.rgba[at + 2]};
}

struct Place {
  int x;
  int y;
};

// The pixel in which a world point is seen. An independent pinhole camera, not the renderer's matrices.
inline Place project(const Camera& camera, int width, int height, Vec3 point) {
  const Vec3 forward = normalized(camera.target - camera.eye);
  const Vec3 right = normalized(cross(forward, camera.up));
  const Vec3 up = cross(right, forward);
  const Vec3 to = point - camera.eye;
  const double focal = 0.5 * height / std::tan(0.5 * camera.vertical_fov * 3.14159265358979323846 / 180.0);
  return {static_cast<int>(std::floor(0.5 * width + focal * dot(to, right) / dot(to, forward))),
          static_cast<int>(std::floor(0.5 * height - focal * dot(to, up) / dot(to, forward)))};
}

inline Rgb pixel_at(const Pixels& pixels, const Camera& camera, Vec3 point) {
  const Place place = project(camera, pixels.width, pixels.height, point);
  return pixel(pixels, place.x, place.y);
}

inline Vec3 vertex(const Sheet& sheet, std::int32_t id) {
  const std::size_t at = 3 * static_cast<std::size_t>(id);
  return {static_cast<double>(sheet.positions[at]), static_cast<double>(sheet.positions[at + 1]),
          static_cast<double>(sheet.positions[at + 2])};
}

inline Vec3 centroid(const Sheet& sheet, std::size_t triangle) {
  const std::int32_t* corners = &sheet.triangles[3 * triangle];
  return (1.0 / 3.0) * (vertex(sheet, corners[0]) + vertex(sheet, corners[1]) + vertex(sheet, corners[2]));
}

}  // namespace kerf::render::testing
