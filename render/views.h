#pragma once

#include "render/linear.h"
#include "render/renderer.h"

namespace kerf::render {

// Holds right-handed, orthonormal axes of a camera: right, up and towards the viewer.
struct ViewAxes {
  Vec3 right;
  Vec3 up;
  Vec3 back;
};
// Returns the axes of a valid camera (see validate).
ViewAxes view_axes(const Camera& camera);

// Holds the two projections of a picture.
struct Views {
  Matrix4 clip_from_world;
  // Factor that moves a point in clip space towards the eye by a fraction f of its distance, keeping its place in the
  // image: z += depth_per_fraction * f / (1 - f).
  double depth_per_fraction = 0.0;
  double pixel_fraction = 0.0;  // -, side of a pixel over its distance from the eye, in the middle of the image.

  Matrix4 shadow_from_world;   // Projection of the key light: orthographic, depth in [-1, 1].
  double shadow_extent = 0.0;  // m, side of the square covered by the shadow map.
  Vec3 to_light;               // Unit vector from the scene to the key light.
};

// Makes the views. `aspect`: width / height; `height`: pixels. `lit` bounds all that casts shadows and must fit the
// shadow map. `seen` bounds all content: the near and far planes enclose it. Neither is empty; `seen` contains `lit`.
// `towards_key`: see Light.
Views make_views(const Camera& camera, double aspect, int height, const Bounds& lit, const Bounds& seen,
                 const std::optional<Vec3>& towards_key = {});

bool is_empty(const Bounds& bounds);
void extend(Bounds& bounds, Vec3 point);
Vec3 centre(const Bounds& bounds);
// Returns the radius of the sphere around the box, m.
double radius(const Bounds& bounds);

}  // namespace kerf::render
