#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/renderer.h"
#include "render/views.h"

namespace kerf::render {

// Represents one corner of a triangle, as read by the vertex shaders. Triangles do not share vertices, so a corner's
// index modulo 3 is its place in the triangle, which the wireframe needs.
struct SurfaceVertex {
  std::array<float, 3> position;  // m, world
  std::array<float, 3> normal;    // Unit; on a sheet, of the front side.
  std::array<float, 2> material;  // Sheet: checks, one unit each; ground: place in the disc, radius 1.
  // Factors on the colour, 128 meaning 1; in a coloured list the colour itself, sRGB. The last one, on a sheet, is the
  // shape: 128 where it is flat, more on ridges and less in valleys as seen from the front, growing with sharpness.
  std::array<std::uint8_t, 4> tint;
};

// Represents an edge used by only one triangle.
struct BorderSegment {
  std::array<float, 3> start;         // m, world
  std::array<float, 3> end;           // m, world
  std::array<float, 3> start_inward;  // From the edge into the sheet; a strip of width w extends w times this,
  std::array<float, 3> end_inward;    // so that the strips of neighbouring segments meet.
  std::array<float, 3> start_normal;  // Unit, of the front side.
  std::array<float, 3> end_normal;
};

// Holds all data of a picture, ready to be copied to the graphics device. Costly work that needs no context is done
// before, on the caller's thread.
struct DrawList {
  int width = 0;                       // pixels
  int height = 0;                      // pixels
  std::vector<SurfaceVertex> sheet;    // 3*T
  std::vector<SurfaceVertex> solids;   // 3 for each triangle of the colliders
  std::vector<SurfaceVertex> ground;   // Squares of each plane; tint is the light from the sky.
  std::vector<BorderSegment> borders;  // Empty unless the style asks for them.
  Views views;
  Vec3 eye;  // m
  Vec3 up;   // unit
  Style style;
  bool textured = false;    // The style asks for it and there are material coordinates.
  bool coloured = false;    // Corners of the sheet have colours of their own.
  double sheet_size = 0.0;  // m, diagonal of the box around the sheet.
};

// Prepares a picture; the arguments must pass validate().
DrawList make_draw_list(const Scene& scene, const Camera& camera, int width, int height);

}  // namespace kerf::render
