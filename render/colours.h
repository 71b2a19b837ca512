#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "render/renderer.h"

// Maps quantities to colours for Mesh::vertex_colours. They equal the viewer's (web/src/scene/strain_colors.ts,
// piece_colors.ts), so that a picture and a viewer agree. The colour-blind can distinguish them too.
namespace kerf::render {

// Converts to linear light, each channel in [0, 1].
Vec3 linear(const Colour& srgb);

using Rgb8 = std::array<std::uint8_t, 3>;  // sRGB

// Returns the cool-warm map of K. Moreland, "Diverging color maps for scientific visualization" (2009). It goes from
// blue over grey to red, darker the farther from 0. `share`: strain over the end of the scale, clamped to [-1, 1]; NaN
// counts as 0.
Rgb8 strain_colour(double share);

// Returns the strain (-) at which a symmetric colour scale ends: 1, 2 or 5 times a power of ten, >= 1e-4. At least 99 %
// of the strains lie within the scale; a few at pins and ends of cuts are many times larger. Returns `current`, the end
// of the previous picture's scale, while the 99 % reach a fifth of it and do not exceed it. Hence the scale does not
// change with every picture. `current` 0: no scale yet. Strains that are not finite are ignored.
double strain_scale_end(std::span<const float> strains, double current = 0.0);

// Returns 3*V values for Mesh::vertex_colours: strain_colour() of each vertex's strain divided by `end` (-, > 0).
std::vector<std::uint8_t> strain_colours(std::span<const float> strains, double end);

// Returns the colour of the piece with this id (>= 1); it depends on the id alone. The first seven ids have the colours
// of M. Okabe and K. Ito, "Color universal design" (2008). The next seven have these colours mixed with white, the next
// seven mixed with black; then all repeat.
Rgb8 piece_colour(std::int64_t id);

}  // namespace kerf::render
