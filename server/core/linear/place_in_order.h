#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace kerf::fem {

// The place of each of some different keys in ascending order. Of few it is counted as the number of keys below, in
// vector code: without a branch that could not be predicted.
void place_in_order(std::span<const std::int32_t> keys, std::vector<std::int32_t>& places);

}  // namespace kerf::fem
