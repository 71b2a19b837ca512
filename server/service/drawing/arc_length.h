#pragma once

#include <vector>

#include "server/core/cut/curve.h"

namespace kerf::drawing {

// Returns the length of a segment that begins at `start`, in the units of its points, to about 1e-9 of it.
double length_of(const Eigen::Vector2d& start, const cut::Segment& segment);
// Returns the length of a line, with the straight line that closes it.
double length_of(const cut::Subpath& line);

Eigen::Vector2d end_of(const cut::Segment& segment);
// Returns the point at parameter t in 0..1. Arcs must have become quadratic pieces.
Eigen::Vector2d point_at(const Eigen::Vector2d& start, const cut::Segment& segment, double t);

// Returns the part of a segment between two parameters, 0 <= from < to <= 1, and where it starts.
struct Part {
  Eigen::Vector2d start;
  cut::Segment segment;
};
Part part_of(const Eigen::Vector2d& start, const cut::Segment& segment, double from, double to);

}  // namespace kerf::drawing
