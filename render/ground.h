#pragma once

#include <vector>

#include "render/draw_list.h"

namespace kerf::render {

// Appends a square to the list's ground. It lies on `plane` under the point `near`, around a disc of this radius (m),
// and the shader draws only the disc. With `sky_light` it is a grid of squares, darker where the list's sheet and
// solids hide the sky. The sheet and solids must stand within a quarter of the radius.
void append_ground(const Plane& plane, Vec3 near, double radius, bool sky_light, DrawList& list);

}  // namespace kerf::render
