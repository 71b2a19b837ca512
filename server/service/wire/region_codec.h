#pragma once

#include <string>
#include <vector>

#include <google/protobuf/repeated_ptr_field.h>

#include "kerf/v1/scene.pb.h"
#include "server/base/result.h"
#include "server/core/scene/command.h"

namespace kerf::wire {

using RegionMessages = google::protobuf::RepeatedPtrField<v1::Region>;

// Decodes pins; checks only faults of the messages themselves. `path` names the repeated field ("pins").
Result<std::vector<scene::Region>> decode_pins(const RegionMessages& pins, const std::string& path);
void encode_pins(const std::vector<scene::Region>& pins, RegionMessages& messages);

// Decodes one region; `path` names it ("constraints[2].region").
Result<scene::Region> decode_region(const v1::Region& region, const std::string& path);
void encode_region(const scene::Region& region, v1::Region& message);

// Decodes wind with the defaults that scene.proto documents for zeros; checks no ranges.
scene::Wind decode_wind(const v1::Wind& wind);
// Encodes wind with an air density > 0. Without air the message must be left absent.
void encode_wind(const scene::Wind& wind, v1::Wind& message);

}  // namespace kerf::wire
