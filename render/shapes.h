#pragma once

#include <vector>

#include "render/draw_list.h"

// Converts colliders to triangles.
namespace kerf::render {

void append_sphere(const Sphere& sphere, std::vector<SurfaceVertex>& out);
void append_box(const Box& box, std::vector<SurfaceVertex>& out);
void append_capsule(const Capsule& capsule, std::vector<SurfaceVertex>& out);

// Extends `bounds`, the box around all that casts shadows, by a collider; a plane adds nothing.
void extend(Bounds& bounds, const Collider& collider);

}  // namespace kerf::render
