#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "render/renderer.h"

// Colours that say something, for Mesh::vertex_colours: the viewer's (web/src/scene/strain_colors.ts, piece_colors.ts),
// so that a picture and a viewer beside it agree. The colour-blind tell them apart, too.
namespace kerf::render {

// In linear light, each channel in [0, 1].
Vec3 linear(const Colour& srgb);

using Rgb8 = std::array<std::uint8_t, 3>;  // sRGB

// Viridis (S. van der Walt, N. Smith, 2015, CC0), whose lightness grows evenly. `share` of the scale is clamped to
// [0, 1].
Rgb8 strain_colour(double share);

// The end of a scale, -, >= 1e-4: 1, 2 or 5 times a power of ten that the largest principal strains of all but 1 % of
// the vertices are below (at pins and ends of cuts a few have many times as much). Stays `current` while that is no
// less than the strains and at most five times as much, so that a scale does not change with every picture; 0: none
// yet. Strains that are not finite are left out.
double strain_scale_end(std::span<const float> strains, double current = 0.0);

// 3*V, as Mesh::vertex_colours wants them: strain_colour() of each vertex's strain over `end` (-, > 0).
std::vector<std::uint8_t> strain_colours(std::span<const float> strains, double end);

// Of the piece with this id (>= 1), always the same: seven colours of M. Okabe and K. Ito, "Color universal design"
// (2008), then those mixed with white, then with black, then the seven again.
Rgb8 piece_colour(std::int64_t id);

}  // namespace kerf::render
