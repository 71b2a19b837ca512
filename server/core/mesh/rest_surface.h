#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "server/base/state_hash.h"

namespace kerf::mesh {

// A flat part of a curved rest surface: an affine image of a part of the material plane.
struct Facet {
  Eigen::Vector2d anchor = Eigen::Vector2d::Zero();  // m, a material point of the facet
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // m, where that lies on the surface
  // Columns: what a metre along material x, and along y, is on the surface. Of rank 2.
  Eigen::Matrix<double, 3, 2> axes = Eigen::Matrix<double, 3, 2>::Zero();
  std::int32_t region = 0;  // label given at import, >= 0

  // Makes the facet of a triangle from its corners in the material plane and on the surface, m. Neither triangle is
  // degenerate.
  static Facet of(const std::array<Eigen::Vector2d, 3>& material, const std::array<Eigen::Vector3d, 3>& surface,
                  std::int32_t region);

  // m, of a material point (m) of the facet's plane.
  [[nodiscard]] Eigen::Vector3d at(const Eigen::Vector2d& material) const {
    return origin + axes * (material - anchor);
  }
  // Returns the same map in the facet's own plane, m per m: the upper triangular factor R of `axes` = Q R, with
  // positive diagonal. The plane's first axis is the image of material x; the second is on the side of the image of y.
  [[nodiscard]] Eigen::Matrix2d stretch() const;
  // m^2 of the surface per m^2 of the material plane, > 0.
  [[nodiscard]] double area_ratio() const;

  friend bool operator==(const Facet& a, const Facet& b) {
    return a.anchor == b.anchor && a.origin == b.origin && a.axes == b.axes && a.region == b.region;
  }
};

// A rest shape that is curved in space: a map of the material plane, affine on each facet and continuous across them
// where the sheet is whole. Edges between facets stay for good: a triangle lies in one facet, whatever is cut, so that
// the surface, its area and its mass are kept.
struct RestSurface {
  std::vector<Facet> facets;

  void add_to(StateHash& hash) const;
  friend bool operator==(const RestSurface&, const RestSurface&) = default;
};

}  // namespace kerf::mesh
