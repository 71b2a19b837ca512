#pragma once

#include <array>
#include <vector>

#include "render/draw_list.h"

namespace kerf::render {

// Defines a plane's coordinates: x and y along it, z above it.
struct PlaneFrame {
  Vec3 origin;  // m
  Vec3 right;   // Unit, as are up and normal, all perpendicular.
  Vec3 up;
  Vec3 normal;
};

// Computes how much light of an even sky is hidden from a plane by the things above it. This darkens the ground under a
// sheet and beside things that stand there.
//
// A small patch hides a share of the light equal to its form factor, |area . d| (d . normal) / (pi |d|^4). Here d is
// the vector from the point of the plane to the patch. Triangles are first gathered in cells; a height below the width
// of a cell counts as that width. The sum of the shares counts light twice that two patches hide, hence occlusion = 1 -
// exp(-sum).
class SkyLight {
 public:
  static constexpr std::size_t kRow = 36;  // Points that occlusion() evaluates at a time.

  // `reach` (m, > 0): triangles are expected up to this distance from the frame's origin in x and y, and up to twice as
  // high. Those beyond are gathered in the outermost cells.
  SkyLight(const PlaneFrame& frame, double reach);

  // Adds triangles; those below the plane are left out. `weight`: 1 for sheets; 1/2 for closed solids, whose near and
  // far side hide the same sky.
  void add(const std::vector<SurfaceVertex>& triangles, double weight);

  // Returns the share of the sky's light that is hidden, in [0, 1), at each point (x[i], y) of the plane, m.
  [[nodiscard]] std::array<float, kRow> occlusion(const std::array<float, kRow>& x, float y) const;

 private:
  static constexpr std::size_t kCells = 20;  // Cells along each side of the grid.

  struct Cell {
    Vec3 moment;        // m^3, sum of centroids, from the frame's origin, times areas.
    Vec3 area;          // m^2, sum of area vectors, all turned to the same side.
    double size = 0.0;  // m^2, sum of areas
  };
  [[nodiscard]] std::size_t cell_of(Vec3 place) const;

  PlaneFrame frame_;
  double reach_;
  std::vector<Cell> cells_;
};

}  // namespace kerf::render
