#pragma once

#include "kerf/v1/scene.pb.h"
#include "server/base/result.h"
#include "server/core/scene/integrator_settings.h"

namespace kerf::wire {

// Decodes an integrator into `settings`; fields absent from the message are left as they are. Error: an enumerator
// unknown to this build.
Status decode_integrator(const v1::Integrator& message, scene::IntegratorSettings& settings);
v1::Integrator encode_integrator(const scene::IntegratorSettings& settings);

}  // namespace kerf::wire
