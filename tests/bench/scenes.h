#pragma once

#include <cstdint>

#include "server/core/sheet/sheet.h"

// Scenes of the benchmarks. Grids of 225, 2,500, 10,000 and 40,000 vertices, 1 m x 1 m.
namespace kerf::bench {

inline constexpr int kGridSides[] = {15, 50, 100, 200};

// A horizontal cloth of demo, side x side vertices, that nothing holds.
scene::SheetConfig horizontal_cloth(int side, scene::IntegratorKind integrator);

// The same right above a ball with friction.
scene::SheetConfig above_ball(scene::SheetConfig cloth);

// The benchmark's scenes are never refused.
sheet::Sheet create(scene::SheetConfig config);

// A horizontal cloth held at two corners, side x side vertices.
sheet::Sheet swinging_cloth(int side, scene::IntegratorKind integrator);

// The same, free, laid on a ball with friction.
sheet::Sheet draped_cloth(int side, scene::IntegratorKind integrator);

// The sheet of "The race" in README.md: E h = 1000 N/m, 0.2 kg/m^2, horizontal, held by its upper edge.
sheet::Sheet race_cloth(int side, scene::IntegratorKind integrator, scene::Precision precision);

// An S-shaped Bezier curve of half the sheet's width, wholly inside it.
scene::Cut s_cut();

}  // namespace kerf::bench
