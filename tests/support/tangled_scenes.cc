#include "tests/support/tangled_scenes.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "server/core/fem/element/material.h"

namespace kerf::scenes {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kWidth = 0.3;  // m
constexpr double kTurn = 0.1;   // rad

// Two grids beside each other in the material plane. The first has columns x rows vertices, the second wide x rows.
// `place(second, i, j)`: of a vertex, m.
template <typename Place>
scene::SheetConfig two_grids(int columns, int wide, int rows, const Place& place) {
  const double h = kWidth / (rows - 1);
  scene::ArraySource source;
  const int first = columns * rows, all = first + wide * rows;
  source.material_positions.resize(2, all);
  source.positions.resize(3, all);
  source.triangles.resize(3, 2 * (rows - 1) * (columns + wide - 2));
  Eigen::Index next = 0;
  for (const bool second : {false, true}) {
    const int width = second ? wide : columns, begin = second ? first : 0;
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < width; ++i) {
        const int a = begin + j * width + i;
        source.material_positions.col(a) = Vector2d(h * i + (second ? 1.2 * kWidth : 0.0), h * j);
        source.positions.col(a) = place(second, i, j);
        if (i + 1 == width || j + 1 == rows) continue;
        source.triangles.col(next++) << a, a + 1, a + 1 + width;
        source.triangles.col(next++) << a, a + 1 + width, a + width;
      }
    }
  }
  scene::SheetConfig config;
  config.material = fem::isotropic(2.0e6, 0.3, 5.0e-4, 400.0);
  config.mesh = std::move(source);
  config.gravity.setZero();
  config.self_contact.is_on = true;
  return config;
}

int width_of_strip(std::int32_t side) {
  return std::max(3, side / 3);
}

// Returns the place at which column i of the strip stands, m. It is off the lines of the grid and slightly turned.
Vector2d below_strip(double h, int wide, bool is_at_border, double i) {
  const double x = is_at_border ? kWidth - 0.5 * h * (wide - 1) - 0.07 * h : 0.5 * (kWidth - h * (wide - 1)) + 0.13 * h;
  return {x + std::cos(kTurn) * h * i, 0.5 * kWidth + 0.21 * h + std::sin(kTurn) * h * i};
}

}  // namespace

scene::SheetConfig pushed_through(double depth, bool is_at_border, std::int32_t side) {
  const double h = kWidth / (side - 1);
  const int wide = width_of_strip(side);
  return two_grids(side, wide, side, [=](bool second, int i, int j) {
    if (!second) return Vector3d(h * i, h * j, 0.0);
    const Vector2d at = below_strip(h, wide, is_at_border, i);
    return Vector3d(at.x(), at.y(), h * j - depth);
  });
}

Vector2d at_strip(double place) {
  constexpr int kSide = 16;
  return below_strip(kWidth / (kSide - 1), width_of_strip(kSide), false, place * (width_of_strip(kSide) - 1));
}

scene::SheetConfig poked_through(double depth, std::int32_t side) {
  const double h = kWidth / (side - 1), apart = 1e-3;
  return two_grids(side, side, side, [=](bool second, int i, int j) {
    if (second) return Vector3d(h * i + 0.23 * h, h * j + 0.31 * h, apart);
    const double away = std::hypot(i - side / 2, j - side / 2) / 1.5;
    return Vector3d(h * i, h * j, (apart + depth) * std::max(0.0, 1.0 - away));
  });
}

}  // namespace kerf::scenes
