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
// A small patch hides a share equal to its form factor, |area . d| (d . normal) / (pi |d|^4), where d is the vector to
// it. Triangles are first gathered in cells, and heights above the plane below the width of a cell count as that width.
// Light that one patch hides behind another counts twice, hence occlusion = 1 - exp(-sum).
class SkyLight {
 public:
  static constexpr std::size_t kRow = 36;  // Points evaluated at a time.

  // `reach` (m, > 0) bounds the things: in x and y around the frame's origin, and 2 reach above it. Those beyond are
  // moved to the border; those below are left out.
  SkyLight(const PlaneFrame& frame, double reach);

  // Adds triangles. `weight`: 1 for sheets; 1/2 for closed solids, whose near and far side hide the same sky.
  void add(const std::vector<SurfaceVertex>& triangles, double weight);

  // Returns the hidden share, in [0, 1), at points (x[i], y) of the plane, m.
  [[nodiscard]] std::array<float, kRow> occlusion(const std::array<float, kRow>& x, float y) const;

 private:
  static constexpr std::size_t kCells = 20;  // Along each side.

  struct Cell {
    Vec3 moment;        // m^3, centroids times areas, from the frame's origin.
    Vec3 area;          // m^2, summed after turning all patches to the same side.
    double size = 0.0;  // m^2
  };
  [[nodiscard]] std::size_t cell_of(Vec3 place) const;

  PlaneFrame frame_;
  double reach_;
  std::vector<Cell> cells_;
};

}  // namespace kerf::render
