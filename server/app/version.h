#pragma once

namespace kerf::app {

inline constexpr const char* kVersion = KERF_VERSION;  // "0.1.0"

}  // namespace kerf::app
