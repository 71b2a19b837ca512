#pragma once

#include <optional>
#include <string_view>

#include <Eigen/Core>

#include "server/core/cut/curve.h"

namespace kerf::svg {

// Maps x to linear x + shift.
struct Affine {
  Eigen::Matrix2d linear = Eigen::Matrix2d::Identity();
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();

  [[nodiscard]] Eigen::Vector2d operator()(const Eigen::Vector2d& point) const { return linear * point + shift; }
  // Returns the composition that applies `inner` first.
  [[nodiscard]] Affine operator*(const Affine& inner) const { return {linear * inner.linear, (*this)(inner.shift)}; }
};

Affine translation(const Eigen::Vector2d& by);

// Parses a transform attribute: matrix, translate, scale, rotate, skewX and skewY. The last one is applied to points
// first. Returns nothing if it is malformed.
std::optional<Affine> parse_transform(std::string_view text);

// Holds a rectangle in user units, with y pointing down.
struct Rectangle {
  Eigen::Vector2d corner{0.0, 0.0};
  Eigen::Vector2d size{0.0, 0.0};
};

// Parses a viewBox attribute. Returns nothing if it is malformed or a side is negative.
std::optional<Rectangle> parse_view_box(std::string_view text);

// Maps coordinates of a view box to those of the viewport that shows it, according to preserveAspectRatio. A malformed
// ratio counts as the default, xMidYMid meet. The sides of both rectangles must be > 0.
Affine view_box_transform(const Rectangle& view_box, const Rectangle& viewport, std::string_view aspect_ratio);

// Returns the transformed subpath. Arcs become rational quadratic segments, which an affine map keeps exact. Arcs
// between equal points are dropped, which may leave the subpath empty.
cut::Subpath transformed(const cut::Subpath& subpath, const Affine& map);

}  // namespace kerf::svg
