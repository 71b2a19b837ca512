#pragma once

#include "kerf/v1/scene.pb.h"
#include "server/base/result.h"
#include "server/core/scene/integrator_settings.h"

namespace kerf::wire {

// Leaves what the message does not give as it is. Error: an enumerator this build does not know.
Status decode_integrator(const v1::Integrator& message, sheet::IntegratorSettings& settings);
v1::Integrator encode_integrator(const sheet::IntegratorSettings& settings);

}  // namespace kerf::wire
