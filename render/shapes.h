#pragma once

#include <vector>

#include "render/draw_list.h"

// Colliders as triangles.
namespace kerf::render {

void append_sphere(const Sphere& sphere, std::vector<SurfaceVertex>& out);
void append_box(const Box& box, std::vector<SurfaceVertex>& out);
void append_capsule(const Capsule& capsule, std::vector<SurfaceVertex>& out);

// What a collider adds to the bounds of what casts shadows; nothing for a plane.
void extend(Bounds& bounds, const Collider& collider);

}  // namespace kerf::render
