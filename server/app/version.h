#pragma once

namespace kerf::app {

inline constexpr const char* kVersion = KERF_VERSION;                     // "0.1.0"
inline constexpr const char* kBuild = KERF_VERSION ", g++ " __VERSION__;  // equal builds promise equal bits

}  // namespace kerf::app
