#pragma once

// The simulation library by itself: a sheet that is stepped, cut and read, without a server or a network.
//
//   kerf::scene::SheetConfig config;                           // mesh, material, pins, bodies, gravity
//   auto sheet = kerf::sheet::Sheet::create(config);           // a sheet, or an Error with the field at fault
//   sheet->step({});                                           // one tick
//   sheet->step(std::array<kerf::scene::Command, 1>{cut});     // one tick that begins with a cut
//   sheet->snapshot()->positions;                              // 3 x V, m
//
// Link kerf::core of find_package(kerf COMPONENTS core). SI units; right-handed world, +z up. A sheet is not
// thread-safe; different sheets are independent. client/tutorial.md has a whole program.
#include "server/base/result.h"                // Result, Error
#include "server/core/analysis/analysis.h"     // equilibria, vibrations, measurements
#include "server/core/contact/collider.h"      // bodies that a sheet rests on
#include "server/core/cut/curve.h"             // curves of cuts, in material coordinates
#include "server/core/cut/cut_types.h"         // options of a cut, and the report on it
#include "server/core/fem/element/material.h"  // materials, and the presets by name
#include "server/core/scene/command.h"         // cuts, grabs, pins, wind, undo; their replies
#include "server/core/scene/conditions.h"      // regions, constraints, loads
#include "server/core/scene/sheet_config.h"    // all that a sheet is made from, and analyses
#include "server/core/sheet/sheet.h"           // the sheet
#include "server/core/sheet/snapshot.h"        // its triangles and positions
