#pragma once

#include <string>

#include "kerf/v1/conditions.pb.h"
#include "kerf/v1/scene.pb.h"
#include "server/base/result.h"
#include "server/core/scene/sheet_config.h"

// Converts kerf.v1.Constraint, Load, History and InitialVelocity to and from sheet's types. Checks only faults of the
// messages themselves, not what scene::validate() checks; errors as in scene_codec.h.
namespace kerf::wire {

// Convert the scene's constraints, loads, gravity_history, planar and initial_velocity.
Status decode_conditions(const v1::Scene& scene, scene::SheetConfig& config);
void encode_conditions(const scene::SheetConfig& config, v1::Scene& scene);

}  // namespace kerf::wire
