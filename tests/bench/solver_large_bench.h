#pragma once

#include <string_view>

#include "server/core/fem/element/material.h"

namespace kerf::bench {

// Prints the table of sheets that are too large for dense matrices, of `only_side` vertices along a side, or, where
// that is 0, of all.
void measure_large(std::string_view name, const fem::Material& material, int only_side);

}  // namespace kerf::bench
