#include "server/base/check.h"
#include "server/base/state_hash.h"
#include "server/core/sheet/saved_sheet.h"
#include "server/core/sheet/sheet.h"

namespace kerf::sheet {

namespace {

// A sheet that hangs over a turned box in the wind and is cut, and touches itself in explicit steps.
scene::SheetConfig probe_sheet(scene::IntegratorKind kind) {
  scene::SheetConfig config;
  config.mesh = scene::GridSource{6, 6, 1.0, 1.0, scene::GridPattern::kJitteredDelaunay, 3};
  config.material.direction = 0.259;
  config.pins = {scene::RegionEdge::kTop};
  config.wind = {Eigen::Vector3d(1.0, 4.0, 0.0), 1.2, 1.0};
  config.colliders = {{contact::OrientedBox{{0.5, 0.05, 0.4}, {0.3, 0.1, 0.1}, {1.0, 0.2, 0.0}, 0.9}, 0.4}};
  config.integrator.kind = kind;
  config.self_contact.is_on = kind == scene::IntegratorKind::kExplicitLeapfrog;
  scene::Cut cut;
  cut.curve = cut::Polyline{{{0.3, 0.3}, {0.7, 0.5}}};
  config.commands = {{2, cut}};
  return config;
}

std::uint64_t measure() {
  StateHash hash;
  for (const scene::IntegratorKind kind : {scene::IntegratorKind::kExplicitLeapfrog, scene::IntegratorKind::kTrBdf2}) {
    Result<Sheet> sheet = Sheet::create(probe_sheet(kind));
    KERF_CHECK(sheet.ok(), "the sheet that measures the engine is valid");
    for (int tick = 0; tick < 5; ++tick) sheet->step({});
    hash.add(sheet->state_hash());
  }
  return hash.value();
}

}  // namespace

std::uint64_t engine_hash() {
  static const std::uint64_t measured = measure();
  return measured;
}

}  // namespace kerf::sheet
