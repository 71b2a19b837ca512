#pragma once

#include "render/renderer.h"

namespace kerf::picture {

// Converts a colour from hexadecimal sRGB.
render::Colour from_hex(unsigned srgb);

// Sets background, ground, solids and light to those of the viewer's page, in its light or its dark theme.
void set_surroundings(bool is_dark, render::Style& style);

}  // namespace kerf::picture
