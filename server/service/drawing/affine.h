#pragma once

#include <Eigen/Core>

#include "server/core/cut/curve.h"

namespace kerf::drawing {

// Maps x to linear x + shift.
struct Affine {
  Eigen::Matrix2d linear = Eigen::Matrix2d::Identity();
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();

  [[nodiscard]] Eigen::Vector2d operator()(const Eigen::Vector2d& point) const { return linear * point + shift; }
  // Returns the composition that applies `inner` first.
  [[nodiscard]] Affine operator*(const Affine& inner) const { return {linear * inner.linear, (*this)(inner.shift)}; }
};

Affine translation(const Eigen::Vector2d& by);

// Returns the transformed subpath. Arcs become rational quadratic segments, which an affine map keeps exact. Arcs
// between equal points are dropped, which may leave the subpath empty.
cut::Subpath transformed(const cut::Subpath& subpath, const Affine& map);

}  // namespace kerf::drawing
