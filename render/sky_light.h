#pragma once

#include <array>
#include <vector>

#include "render/draw_list.h"

namespace kerf::render {

// A plane's coordinates: x and y along it, z above it.
struct PlaneFrame {
  Vec3 origin;  // m
  Vec3 right;   // unit, as are up and normal, at right angles
  Vec3 up;
  Vec3 normal;
};

// How much of the light of an even sky things above a plane take from it: what is dark under a sheet and beside what
// stands there. The share of the sky's light on the plane that a small patch takes is its form factor, |area . d| (d .
// normal) / (pi |d|^4) for the way d to it. Triangles are gathered in cells first, and what is nearer to the plane than
// a cell is wide counts as that far. What one patch hides behind another counts twice, hence occlusion = 1 - exp(-sum).
class SkyLight {
 public:
  static constexpr std::size_t kRow = 36;  // points evaluated at a time

  // Things are within `reach` (m, > 0) of the frame's origin in x and y and 2 reach above it; what is beyond is taken
  // to the border, what is below is left out.
  SkyLight(const PlaneFrame& frame, double reach);

  // `weight`: 1 for sheets; 1/2 for closed solids, whose near and far side hide the same sky.
  void add(const std::vector<SurfaceVertex>& triangles, double weight);

  // The share that is taken, in [0, 1), at points (x[i], y) of the plane, m.
  [[nodiscard]] std::array<float, kRow> occlusion(const std::array<float, kRow>& x, float y) const;

 private:
  static constexpr std::size_t kCells = 20;  // along each side

  struct Cell {
    Vec3 moment;        // m^3, centroids times sizes, from the frame's origin
    Vec3 area;          // m^2, of patches that all look the same way or are turned round to
    double size = 0.0;  // m^2
  };
  [[nodiscard]] std::size_t cell_of(Vec3 place) const;

  PlaneFrame frame_;
  double reach_;
  std::vector<Cell> cells_;
};

}  // namespace kerf::render
