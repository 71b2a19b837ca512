#pragma once

#include <string>
#include <string_view>

#include "server/base/result.h"
#include "server/service/host/saved_states.h"

// Encodes saved states of sheets as a store keeps them: kerf.v1.StoredSheetState.
namespace kerf::durable {

std::string encode_state(const host::SavedState& state);
// Returns the state without its scene. Error kDataLoss STATE_DAMAGED for other bytes than those of encode_state().
Result<host::SavedState> decode_state(std::string_view bytes);

}  // namespace kerf::durable
