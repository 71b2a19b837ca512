#pragma once

#include <vector>

#include "render/draw_list.h"

namespace kerf::render {

// A square around the disc of the given radius (m) on the plane under `near`; the shader keeps the disc. With
// `sky_light` it is made of many squares, darker where the list's sheet and solids hide the sky; otherwise of one.
// These must stand within a quarter of the radius.
void append_ground(const Plane& plane, Vec3 near, double radius, bool sky_light, DrawList& list);

}  // namespace kerf::render
