#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/renderer.h"
#include "render/views.h"

namespace kerf::render {

// One corner of a triangle, as the vertex shaders read it. Triangles do not share vertices, so that a corner's place in
// its triangle, from which the wireframe comes, is its index modulo 3.
struct SurfaceVertex {
  std::array<float, 3> position;  // m, world
  std::array<float, 3> normal;    // unit; on a sheet, of the front side
  std::array<float, 2> material;  // sheet: checks, one unit each; ground: place in the disc, radius 1
  // Factors on the colour over 255, of which 128/255 leaves it as it is; where the list is coloured, the colour, sRGB.
  // The last, on a sheet: 128 where it is flat, more on ridges and less in valleys as the front sees them; the sharper
  // they are the more.
  std::array<std::uint8_t, 4> tint;
};

// An edge that only one triangle uses.
struct BorderSegment {
  std::array<float, 3> start;         // m, world
  std::array<float, 3> end;           // m, world
  std::array<float, 3> start_inward;  // from the edge into the sheet, along it; a strip of width w is w times as wide
  std::array<float, 3> end_inward;    // so that the strips of neighbours meet
  std::array<float, 3> start_normal;  // unit, of the front side
  std::array<float, 3> end_normal;
};

// All that a picture takes, ready to be copied to the graphics device: what is costly and needs no context is done on
// the caller's thread.
struct DrawList {
  int width = 0;                       // pixels
  int height = 0;                      // pixels
  std::vector<SurfaceVertex> sheet;    // 3*T
  std::vector<SurfaceVertex> solids;   // 3 for each triangle of the colliders
  std::vector<SurfaceVertex> ground;   // squares of each plane; tint is the light from the sky
  std::vector<BorderSegment> borders;  // empty unless the style asks for them
  Views views;
  Vec3 eye;  // m
  Vec3 up;   // unit
  Style style;
  bool textured = false;    // the style asks for it and there are material coordinates
  bool coloured = false;    // corners of the sheet have colours of their own
  double sheet_size = 0.0;  // m, diagonal of the box around the sheet
};

// Of arguments that passed validate().
DrawList make_draw_list(const Scene& scene, const Camera& camera, int width, int height);

}  // namespace kerf::render
