#pragma once

#include <optional>
#include <string_view>

#include <Eigen/Core>

#include "server/core/cut/curve.h"

namespace kerf::svg {

// x -> linear x + shift.
struct Affine {
  Eigen::Matrix2d linear = Eigen::Matrix2d::Identity();
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();

  [[nodiscard]] Eigen::Vector2d operator()(const Eigen::Vector2d& point) const { return linear * point + shift; }
  // First `inner`, then this.
  [[nodiscard]] Affine operator*(const Affine& inner) const { return {linear * inner.linear, (*this)(inner.shift)}; }
};

Affine translation(const Eigen::Vector2d& by);

// The value of a transform attribute: matrix, translate, scale, rotate, skewX and skewY, the last applied first.
// Nothing where it cannot be read.
std::optional<Affine> parse_transform(std::string_view text);

// A rectangle with y down, in user units.
struct Rectangle {
  Eigen::Vector2d corner{0.0, 0.0};
  Eigen::Vector2d size{0.0, 0.0};
};

// The value of a viewBox attribute; nothing where it cannot be read or a side is negative.
std::optional<Rectangle> parse_view_box(std::string_view text);

// From the coordinates of a view box to those of the viewport that shows it, as preserveAspectRatio says; what cannot
// be read is its default, xMidYMid meet. Sides of both > 0.
Affine view_box_transform(const Rectangle& view_box, const Rectangle& viewport, std::string_view aspect_ratio);

// The subpath transformed; arcs become rational quadratic segments, which an affine map keeps exact. Arcs between equal
// points are left out, and with them the subpath may be empty.
cut::Subpath transformed(const cut::Subpath& subpath, const Affine& map);

}  // namespace kerf::svg
