#pragma once

#include <vector>

#include "kerf/v1/analysis.pb.h"
#include "kerf/v1/scene.pb.h"
#include "server/base/result.h"
#include "server/core/analysis/analysis.h"
#include "server/core/scene/sheet_config.h"

// Converts kerf.v1.Analysis and Probe to and from sheet's types. Checks only faults of the message itself, not what
// scene::validate() checks; errors as in scene_codec.h.
namespace kerf::wire {

// Decode with the defaults that analysis.proto documents for zeros; field paths of errors begin with "analysis" and
// "probes".
Result<scene::Analysis> decode_analysis(const v1::Analysis& message);
Result<std::vector<scene::Probe>> decode_probes(const google::protobuf::RepeatedPtrField<v1::Probe>& messages);

// Encode the results of an analysis.
v1::Table encode_table(const analysis::Table& table);
v1::StaticResult encode_statics(const analysis::StaticStats& stats);
v1::DynamicResult encode_dynamics(const analysis::DynamicStats& stats);  // Leaves out energies and hash.

// Convert the scene's analysis and probes, with the defaults that analysis.proto documents for zeros.
Status decode_analysis(const v1::Scene& scene, scene::SheetConfig& config);
void encode_analysis(const scene::SheetConfig& config, v1::Scene& scene);

}  // namespace kerf::wire
