#pragma once

#include "render/linear.h"
#include "render/renderer.h"

namespace kerf::render {

// Right-handed, orthonormal: what the camera calls right, up and towards the viewer.
struct ViewAxes {
  Vec3 right;
  Vec3 up;
  Vec3 back;
};
// Of a valid camera (see validate).
ViewAxes view_axes(const Camera& camera);

// The two projections of a picture.
struct Views {
  Matrix4 clip_from_world;
  // From clip space w to the clip z of a point moved towards the eye by a fraction f of its distance, keeping its place
  // in the image: z += depth_per_fraction * f / (1 - f).
  double depth_per_fraction = 0.0;
  double pixel_fraction = 0.0;  // -, side of a pixel over its distance from the eye, in the middle of the image

  Matrix4 shadow_from_world;   // the key light's, orthographic, depth in [-1, 1]
  double shadow_extent = 0.0;  // m, side of the square that the shadow map covers
  Vec3 to_light;               // unit, from the scene
};

// `lit` is what casts shadows and must fit the shadow map; `seen` is all there is, between whose nearest and farthest
// points the near and far planes go. Neither is empty, `seen` holds `lit`.
Views make_views(const Camera& camera, double aspect, int height, const Bounds& lit, const Bounds& seen);

bool is_empty(const Bounds& bounds);
void extend(Bounds& bounds, Vec3 point);
Vec3 centre(const Bounds& bounds);
// m, of the sphere around the box.
double radius(const Bounds& bounds);

}  // namespace kerf::render
