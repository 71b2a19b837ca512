#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/sheet/snapshot.h"

// Colours of vertices, 3 V bytes, sRGB: those of the browser's viewer (web/src/scene/).
namespace kerf::api {

// One for each piece label. No two pieces share a vertex; vertices without a piece are grey.
std::vector<std::uint8_t> piece_colours(const sheet::Topology& topology);

// Strains that are not finite count as 0.

// The end of a scale of strains (-, >= 1e-4): 1, 2 or 5 times a power of ten that 99 % of the vertices are below, as a
// few at pins and the ends of cuts have many times as much. `current`: the end so far (0: none), kept while it fits.
double strain_scale_end(std::span<const float> strains, double current);

// From dark (0 and below) to yellow (`end`, > 0, and beyond).
std::vector<std::uint8_t> strain_colours(std::span<const float> strains, double end);

}  // namespace kerf::api
