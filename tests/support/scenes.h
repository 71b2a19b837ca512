#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "server/core/fem/element/material.h"
#include "server/core/scene/sheet_config.h"

// Provides scenes for tests, benchmarks and the soak test.
namespace kerf::scenes {

inline fem::Material demo_material() {
  return fem::find_preset("demo").value();
}

// Returns a sheet of 1 m x 1 m with n x n vertices that hangs by its top edge in the x-z plane.
inline scene::SheetConfig hanging(std::int32_t n) {
  scene::SheetConfig config;
  config.mesh = scene::GridSource{n, n, 1.0, 1.0, scene::GridPattern::kUniformDiagonals, 0};
  config.material = demo_material();
  config.pins = {scene::RegionEdge::kTop};
  return config;
}

// Returns a sheet of 1 m x 1 m in the plane z = 0, without pins and gravity.
inline scene::SheetConfig flat(std::int32_t n) {
  scene::SheetConfig config = hanging(n);
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.pins.clear();
  config.gravity.setZero();
  return config;
}

inline scene::Cut bezier_cut(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                             const Eigen::Vector2d& d) {
  scene::Cut cut;
  cut.curve = cut::CubicBezier{{a, b, c, d}};
  return cut;
}

inline scene::Cut line_cut(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  scene::Cut cut;
  cut.curve = cut::Polyline{{a, b}};
  return cut;
}

inline scene::Cut circle_cut(const Eigen::Vector2d& centre, double radius) {
  scene::Cut cut;
  cut.curve = cut::Circle{centre, radius};
  return cut;
}

// Returns a Bezier slit inside the sheet, a circle and a line across the sheet: 3 pieces in the end.
inline std::vector<scene::Cut> three_cuts() {
  return {bezier_cut({0.2, 0.5}, {0.4, 0.8}, {0.6, 0.2}, {0.8, 0.5}), circle_cut({0.3, 0.3}, 0.1),
          line_cut({-0.1, 0.85}, {1.1, 0.8})};
}

// Returns hanging(n) with three_cuts() at ticks 10, 20 and 30.
inline scene::SheetConfig hanging_with_three_cuts(std::int32_t n) {
  scene::SheetConfig config = hanging(n);
  std::int64_t tick = 10;
  for (scene::Cut& cut : three_cuts()) {
    scene::ScheduledCommand& scheduled = config.commands.emplace_back();
    scheduled.tick = tick;
    scheduled.command = std::move(cut);
    tick += 10;
  }
  return config;
}

// Returns a horizontal sheet of 1 m x 1 m with n x n vertices, 10 cm above a sphere of radius 0.3 m around the origin.
inline scene::SheetConfig draped_over_sphere(std::int32_t n) {
  scene::SheetConfig config = hanging(n);
  config.placement.origin = {-0.5, -0.5, 0.4};
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.pins.clear();
  config.colliders = {{contact::Sphere{{0.0, 0.0, 0.0}, 0.3}, 0.4}};
  return config;
}

// Returns a sheet lying on a floor; it only settles a little at first.
inline scene::SheetConfig lying_on_floor(std::int32_t n) {
  scene::SheetConfig config = hanging(n);
  config.placement.origin = {0.0, 0.0, 0.5 * config.material.thickness};
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.pins.clear();
  config.colliders = {{contact::Plane{{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}}, 0.5}};
  return config;
}

}  // namespace kerf::scenes
