#pragma once

#include <string>

#include "kerf/v1/scene.pb.h"
#include "server/base/result.h"
#include "server/core/scene/sheet_config.h"

namespace kerf::wire {

// Decodes the preset, overridden by the fields given. kInvalidArgument UNKNOWN_PRESET, NOT_FINITE, OUT_OF_RANGE (ranges
// of scene.proto), MATERIAL_NOT_POSITIVE_DEFINITE; fields begin with `path` ("material").
Result<fem::Material> decode_material(const v1::Material& material, const std::string& path);

// Encodes every number and no preset; bending stiffnesses only if they were given to the material.
v1::Material encode_material(const fem::Material& material);

// Decodes a membrane law. Errors: UNKNOWN_ENUM_VALUE, "membrane_law".
Status decode_membrane_law(v1::MembraneLaw message, fem::MembraneLaw& law);
v1::MembraneLaw encode_membrane_law(fem::MembraneLaw law);

}  // namespace kerf::wire
