#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace kerf::linear {

// Sets `places` to the rank of each key in ascending order; keys are distinct. The rank of few keys is counted as the
// number of smaller keys, in vector code without unpredictable branches.
void rank_ascending(std::span<const std::int32_t> keys, std::vector<std::int32_t>& places);

}  // namespace kerf::linear
