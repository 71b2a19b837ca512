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
  std::array<float, 2> material;  // On a sheet in pairs of bands; on the ground, place in a disc of radius 1.
  // The first three are factors on red, green and blue, 128 meaning 1; in a coloured list they are the sRGB colour
  // itself. The fourth is the shape of a sheet seen from the front: 128 where flat, more on ridges, less in valleys. It
  // is the farther from 128, the sharper the ridge or valley is.
  std::array<std::uint8_t, 4> tint;
  float look = 0.0F;  // On a sheet, number in Style::looks.
};

// Represents an edge used by only one triangle.
struct BorderSegment {
  std::array<float, 3> start;         // m, world
  std::array<float, 3> end;           // m, world
  std::array<float, 3> start_inward;  // Vector at `start` into the sheet; a strip of width w extends w times it.
  std::array<float, 3> end_inward;    // The same at `end`. Longer than 1 at corners, so that strips meet.
  std::array<float, 3> start_normal;  // Unit, of the front side.
  std::array<float, 3> end_normal;
  float look = 0.0F;  // Number in Style::looks.
};

// Holds all data of a picture, ready to be copied to the graphics device. Costly work that needs no graphics context,
// such as normals, has been done before on the caller's thread.
struct DrawList {
  int width = 0;                       // pixels
  int height = 0;                      // pixels
  std::vector<SurfaceVertex> sheet;    // 3 for each triangle of the mesh
  std::vector<SurfaceVertex> solids;   // 3 for each triangle of the colliders
  std::vector<SurfaceVertex> ground;   // Squares of each ground plane; the tint is the light from the sky.
  std::vector<BorderSegment> borders;  // Empty unless the style asks for them.
  Views views;
  Vec3 eye;  // m
  Vec3 up;   // unit
  Style style;
  bool textured = false;    // True if the style asks for the texture and there are material coordinates.
  bool coloured = false;    // True if the mesh has vertex colours.
  double sheet_size = 0.0;  // m, diagonal of the box around the sheet.
};

// Prepares a picture; the arguments must pass validate().
DrawList make_draw_list(const Scene& scene, const Camera& camera, int width, int height);

}  // namespace kerf::render
