#include "tests/bench/scenes.h"

#include <utility>

#include "server/base/check.h"
#include "server/core/fem/element/material.h"

namespace kerf::bench {

scene::SheetConfig horizontal_cloth(int side, scene::IntegratorKind integrator) {
  scene::SheetConfig config;
  scene::GridSource grid;
  grid.columns = side;
  grid.rows = side;
  config.mesh = grid;
  config.material = fem::find_preset("demo").value();
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.integrator.kind = integrator;
  return config;
}

scene::SheetConfig above_ball(scene::SheetConfig cloth) {
  cloth.placement.origin = {-0.5, -0.5, 0.31};
  cloth.colliders = {{contact::Sphere{{0.0, 0.0, 0.0}, 0.3}, 0.4}};
  return cloth;
}

sheet::Sheet create(scene::SheetConfig config) {
  Result<sheet::Sheet> sheet = sheet::Sheet::create(std::move(config));
  KERF_CHECK(sheet.ok(), "the benchmark scene is refused");
  return std::move(sheet).value();
}

sheet::Sheet swinging_cloth(int side, scene::IntegratorKind integrator) {
  scene::SheetConfig config = horizontal_cloth(side, integrator);
  config.pins.emplace_back(scene::RegionEdge::kTopCorners);
  return create(std::move(config));
}

sheet::Sheet draped_cloth(int side, scene::IntegratorKind integrator) {
  return create(above_ball(horizontal_cloth(side, integrator)));
}

sheet::Sheet race_cloth(int side, scene::IntegratorKind integrator, scene::Precision precision) {
  scene::SheetConfig config = horizontal_cloth(side, integrator);
  config.material = fem::isotropic(2.0e6, 0.3, 5.0e-4, 400.0);
  config.pins.emplace_back(scene::RegionEdge::kTop);
  config.integrator.precision = precision;
  return create(std::move(config));
}

scene::Cut s_cut() {
  scene::Cut cut;
  cut.curve = cut::CubicBezier{{{0.25, 0.5}, {0.4, 0.9}, {0.6, 0.1}, {0.75, 0.5}}};
  return cut;
}

}  // namespace kerf::bench
