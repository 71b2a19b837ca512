#pragma once

#include <cstdint>

#include "server/core/sheet/initial_state.h"

namespace kerf::sheet {

// Hashes a sheet as its scene made it, and the settings that decide its future. Curves and other contents of scheduled
// commands are left out, as is what has no effect on the motion.
std::uint64_t scene_hash(const InitialState& initial);

}  // namespace kerf::sheet
