#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "server/base/state_hash.h"

namespace kerf::mesh {

// A flat part of a curved rest shape: the image of a part of the material plane under an affine map.
struct Facet {
  Eigen::Vector2d anchor = Eigen::Vector2d::Zero();  // m, a material point of the facet
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // m, place of `anchor` on the surface
  // Columns: the vector on the surface for one metre along material x, and along material y, m per m. Rank 2.
  Eigen::Matrix<double, 3, 2> axes = Eigen::Matrix<double, 3, 2>::Zero();
  std::int32_t region = 0;  // label given at import, >= 0

  // Makes the facet of a triangle from its corners in the material plane and on the surface, m. Neither triangle is
  // degenerate.
  static Facet of(const std::array<Eigen::Vector2d, 3>& material, const std::array<Eigen::Vector3d, 3>& surface,
                  std::int32_t region);

  // Returns the place on the surface (m) of a point in material coordinates (m).
  [[nodiscard]] Eigen::Vector3d at(const Eigen::Vector2d& material) const {
    return origin + axes * (material - anchor);
  }
  // Returns the linear part of the facet's map in coordinates of its own plane, m per m. It is the factor R of `axes` =
  // Q R: upper triangular, with positive diagonal. The first axis of the plane is the image of material x; the second
  // is on the side of the image of material y.
  [[nodiscard]] Eigen::Matrix2d stretch() const;
  // Returns the area on the surface per area in the material plane, > 0.
  [[nodiscard]] double area_ratio() const;

  friend bool operator==(const Facet& a, const Facet& b) {
    return a.anchor == b.anchor && a.origin == b.origin && a.axes == b.axes && a.region == b.region;
  }
};

// A rest shape that is curved in space: a map of the material plane, affine on each facet and continuous across them
// where the sheet is whole. No cut removes the edges between facets. So each triangle always lies in one facet, and the
// surface keeps its area and mass.
struct RestSurface {
  std::vector<Facet> facets;

  void add_to(StateHash& hash) const;
  friend bool operator==(const RestSurface&, const RestSurface&) = default;
};

}  // namespace kerf::mesh
