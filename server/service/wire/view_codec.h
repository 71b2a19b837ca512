#pragma once

#include "kerf/v1/scene.pb.h"
#include "server/base/result.h"
#include "server/core/scene/command.h"

namespace kerf::wire {

// Decodes a view; checks only the form of the message. Errors: FIELD_MISSING without a camera or matrices,
// CHOICE_MISSING with both, MATRIX_SIZE, UNKNOWN_ENUM_VALUE; CAMERA_SINGULAR and FOV_OUT_OF_RANGE for a camera that
// gives no matrices.
Result<cut::View> decode_view(const v1::View& message, const std::string& path);
// Encodes a view as matrices.
void encode_view(const cut::View& view, v1::View& message);

}  // namespace kerf::wire
