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

// The cool-warm map of K. Moreland, "Diverging color maps for scientific visualization" (2009): from blue over grey to
// red, darker the farther from 0. `share` of the scale is clamped to [-1, 1], and 0 where it is not a number.
Rgb8 strain_colour(double share);

// The end of a scale, -, >= 1e-4, which begins at its negative: 1, 2 or 5 times a power of ten that the magnitudes of
// all but 1 % of the strains are below (at pins and ends of cuts a few have many times as much). Stays `current` while
// that is no less than they are and at most five times as much, so that a scale does not change with every picture;
// 0: none yet. Strains that are not finite are left out.
double strain_scale_end(std::span<const float> strains, double current = 0.0);

// 3*V, as Mesh::vertex_colours wants them: strain_colour() of each vertex's strain over `end` (-, > 0).
std::vector<std::uint8_t> strain_colours(std::span<const float> strains, double end);

// Of the piece with this id (>= 1), always the same: seven colours of M. Okabe and K. Ito, "Color universal design"
// (2008), then those mixed with white, then with black, then the seven again.
Rgb8 piece_colour(std::int64_t id);

}  // namespace kerf::render
