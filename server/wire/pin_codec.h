#pragma once

#include <string>
#include <vector>

#include <google/protobuf/repeated_ptr_field.h>

#include "kerf/v1/scene.pb.h"
#include "server/base/result.h"
#include "server/sheet/command.h"

namespace kerf::wire {

using PinRegionMessages = google::protobuf::RepeatedPtrField<v1::PinRegion>;

// Unchecked, but for what only the message can get wrong; `path` names the repeated field ("pins").
Result<std::vector<sheet::PinRegion>> decode_pins(const PinRegionMessages& pins, const std::string& path);
void encode_pins(const std::vector<sheet::PinRegion>& pins, PinRegionMessages& messages);

// Wind with the defaults that scene.proto documents for zeros; unchecked.
sheet::Wind decode_wind(const v1::Wind& wind);
// Moving air only: what a receiver takes from an absent message is no air at all.
void encode_wind(const sheet::Wind& wind, v1::Wind& message);

}  // namespace kerf::wire
