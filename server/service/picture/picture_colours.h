#pragma once

#include <cstdint>
#include <vector>

#include "server/core/sheet/snapshot.h"

namespace kerf::picture {

// Returns colours of vertices, 3 V bytes, sRGB: render::piece_colour() of the piece of each vertex, with pieces counted
// from 1. No two pieces share a vertex; vertices without a piece are grey.
std::vector<std::uint8_t> piece_colours(const sheet::Topology& topology);

}  // namespace kerf::picture
