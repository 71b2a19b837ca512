#include "tests/bench/scenes.h"

#include <utility>

#include "server/base/check.h"
#include "server/fem/material.h"

namespace kerf::bench {

sheet::Sheet swinging_cloth(int side, sheet::IntegratorKind integrator) {
  sheet::SheetConfig config;
  sheet::GridSource grid;
  grid.columns = side;
  grid.rows = side;
  config.mesh = grid;
  config.material = fem::find_preset("demo").value();
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.pins.emplace_back(sheet::PinEdge::kTopCorners);
  config.integrator.kind = integrator;
  Result<sheet::Sheet> sheet = sheet::Sheet::create(std::move(config));
  KERF_CHECK(sheet.ok(), "the benchmark scene is refused");
  return std::move(sheet).value();
}

sheet::Cut s_cut() {
  sheet::Cut cut;
  cut.curve = cut::CubicBezier{{{0.25, 0.5}, {0.4, 0.9}, {0.6, 0.1}, {0.75, 0.5}}};
  return cut;
}

}  // namespace kerf::bench
