#pragma once

#include <cstdint>

namespace kerf::dxf {

// Returns the colour, 0xrrggbb, of an index of AutoCAD, 1..255. Index 7 is black, as on paper.
std::uint32_t indexed_colour(int index);

}  // namespace kerf::dxf
