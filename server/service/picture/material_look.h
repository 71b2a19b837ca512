#pragma once

#include "render/renderer.h"

namespace kerf::picture {

// Holds the numbers of a material by which its look is chosen.
struct LookNumbers {
  double modulus = 0.0;    // Pa, the larger Young's modulus, > 0
  double thickness = 0.0;  // m, > 0
  double density = 0.0;    // kg/m^3, > 0
};

// Returns the look of a sheet of this material: that of the preset whose stiffness, thickness and density are nearest,
// by their ratios. The viewer has the same looks, in web/src/scene/material_looks.ts.
render::Look look_of(const LookNumbers& numbers);

}  // namespace kerf::picture
