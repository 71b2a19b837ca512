#pragma once

#include <optional>
#include <string_view>

#include <Eigen/Core>

#include "server/service/drawing/affine.h"
#include "server/service/svg/attributes.h"

namespace kerf::svg {

using drawing::Affine;
using drawing::transformed;
using drawing::translation;

// Parses a transform attribute or property: matrix, translate, scale, rotate, skewX and skewY, and the forms of CSS for
// one axis. Numbers may have the units px, deg, grad, rad or turn. The last one is applied to points first. Returns
// nothing if it is malformed.
std::optional<Affine> parse_transform(std::string_view text);

// Parses transform-origin: lengths, percentages of the viewport, or names of its sides. Returns nothing if it is
// malformed.
std::optional<Eigen::Vector2d> parse_origin(std::string_view text, const Viewport& viewport);

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

}  // namespace kerf::svg
