#pragma once

#include <cstdint>

#include "server/base/result.h"
#include "server/core/fem/step/integrator_options.h"
#include "server/core/scene/sheet_config.h"

namespace kerf::scene {

// Checks ranges. Fields are named as in kerf.v1.Scene ("integrator.max_substeps").
Status validate(const IntegratorSettings& settings);

// vertex_limit() returns the most vertices that a sheet with these settings may have, at the start and after cuts.
// check_vertex_limit() refuses more: kResourceExhausted SOLVER_TOO_DENSE.
std::int32_t vertex_limit(const IntegratorSettings& settings);
Status check_vertex_limit(const IntegratorSettings& settings, std::int32_t num_vertices);

// Returns true for integrators that are always implicit.
[[nodiscard]] bool is_implicit(IntegratorKind kind);

// Convert the settings, or those of a scene with its tick, to the options of `fem`. tick: s, > 0. touches_itself: true
// if self-contact is on.
fem::IntegratorOptions integrator_options(const IntegratorSettings& settings, double tick);
fem::IntegratorOptions integrator_options(const SheetConfig& config, bool touches_itself);

}  // namespace kerf::scene
