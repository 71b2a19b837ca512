#pragma once

#include "kerf/v1/analysis.pb.h"
#include "kerf/v1/scene.pb.h"
#include "server/base/result.h"
#include "server/sheet/sheet_config.h"

// kerf.v1.Analysis and Probe <-> sheet's. Unchecked, but for what only messages can get wrong; errors as in
// scene_codec.h.
namespace kerf::wire {

// The scene's analysis and probes, with the defaults that analysis.proto documents for zeros.
Status decode_analysis(const v1::Scene& scene, sheet::SheetConfig& config);
void encode_analysis(const sheet::SheetConfig& config, v1::Scene& scene);

}  // namespace kerf::wire
