#include "server/service/drawing/arc_length.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

#include "server/core/cut/arc.h"

namespace kerf::drawing {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A Bezier segment in homogeneous coordinates: (w x, w y, w).
struct Piece {
  int degree = 1;
  std::array<Vector3d, 4> points;
};

Vector3d lifted(const Vector2d& point, double weight) {
  return {weight * point.x(), weight * point.y(), weight};
}

Vector2d dropped(const Vector3d& point) {
  return point.head<2>() / point.z();
}

Piece piece_from(const Vector2d& start, const cut::Segment& segment) {
  Piece piece;
  if (const auto* line = std::get_if<cut::LineTo>(&segment)) {
    piece.points = {lifted(start, 1.0), lifted(line->end, 1.0), Vector3d::Zero(), Vector3d::Zero()};
  } else if (const auto* quadratic = std::get_if<cut::QuadraticTo>(&segment)) {
    const auto& w = quadratic->weights;
    piece.degree = 2;
    piece.points = {lifted(start, w[0]), lifted(quadratic->control, w[1]), lifted(quadratic->end, w[2]),
                    Vector3d::Zero()};
  } else if (const auto* cubic = std::get_if<cut::CubicTo>(&segment)) {
    const auto& w = cubic->weights;
    piece.degree = 3;
    piece.points = {lifted(start, w[0]), lifted(cubic->controls[0], w[1]), lifted(cubic->controls[1], w[2]),
                    lifted(cubic->end, w[3])};
  }
  return piece;
}

// Divides a piece by de Casteljau's algorithm; `left` and `right` may not be the piece itself.
void divide(const Piece& piece, double t, Piece& left, Piece& right) {
  left.degree = right.degree = piece.degree;
  right.points = piece.points;
  const auto n = static_cast<std::size_t>(piece.degree);
  left.points[0] = piece.points[0];
  for (std::size_t level = 1; level <= n; ++level) {
    for (std::size_t i = 0; i + level <= n; ++i) {
      right.points[i] = (1.0 - t) * right.points[i] + t * right.points[i + 1];
    }
    left.points[level] = right.points[0];
  }
}

cut::Segment segment_from(const Piece& piece) {
  const auto point = [&piece](std::size_t i) { return dropped(piece.points[i]); };
  // Weights are scaled so that the first is 1; the limits of weights hold for what a division leaves.
  const auto weight = [&piece](std::size_t i) { return piece.points[i].z() / piece.points[0].z(); };
  if (piece.degree == 1) return cut::LineTo{point(1)};
  if (piece.degree == 2) return cut::QuadraticTo{point(1), point(2), {1.0, weight(1), weight(2)}};
  return cut::CubicTo{{point(1), point(2)}, point(3), {1.0, weight(1), weight(2), weight(3)}};
}

// Adds up chords and control polygons, and halves the piece until both agree (Gravesen 1997).
double length_between(const Piece& piece, double enough, int depth) {
  const auto n = static_cast<std::size_t>(piece.degree);
  const double chord = (dropped(piece.points[n]) - dropped(piece.points[0])).norm();
  double polygon = 0.0;
  for (std::size_t i = 0; i < n; ++i) polygon += (dropped(piece.points[i + 1]) - dropped(piece.points[i])).norm();
  const double share = piece.degree == 2 ? 1.0 / 3.0 : 0.5;  // Share of the polygon in the mean of both.
  if (piece.degree == 1) return chord;
  if (!(polygon - chord > enough) || depth == 0) return (1.0 - share) * chord + share * polygon;
  Piece left;
  Piece right;
  divide(piece, 0.5, left, right);
  return length_between(left, 0.5 * enough, depth - 1) + length_between(right, 0.5 * enough, depth - 1);
}

double length_of_piece(const Piece& piece) {
  double polygon = 0.0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(piece.degree); ++i) {
    polygon += (dropped(piece.points[i + 1]) - dropped(piece.points[i])).norm();
  }
  return length_between(piece, 1.0e-6 * polygon, 10);
}

}  // namespace

Vector2d end_of(const cut::Segment& segment) {
  return std::visit([](const auto& each) { return each.end; }, segment);
}

double length_of(const Vector2d& start, const cut::Segment& segment) {
  if (const auto* arc = std::get_if<cut::ArcTo>(&segment)) {
    double length = 0.0;
    Vector2d at = start;
    for (const cut::QuadraticTo& piece : cut::arc_pieces(start, *arc).segments) {
      length += length_of(at, piece);
      at = piece.end;
    }
    return length;
  }
  return length_of_piece(piece_from(start, segment));
}

double length_of(const cut::Subpath& line) {
  double length = 0.0;
  Vector2d at = line.start;
  for (const cut::Segment& segment : line.segments) {
    length += length_of(at, segment);
    at = end_of(segment);
  }
  return line.closed ? length + (line.start - at).norm() : length;
}

Vector2d point_at(const Vector2d& start, const cut::Segment& segment, double t) {
  if (t <= 0.0) return start;
  if (t >= 1.0) return end_of(segment);
  Piece left;
  Piece right;
  divide(piece_from(start, segment), t, left, right);
  return dropped(right.points[0]);
}

Part part_of(const Vector2d& start, const cut::Segment& segment, double from, double to) {
  Piece piece = piece_from(start, segment);
  Piece left;
  Piece right;
  Part part{start, segment};
  if (from > 0.0) {
    divide(piece, from, left, right);
    piece = right;
    part.start = dropped(piece.points[0]);
  }
  if (to < 1.0) {
    divide(piece, (to - from) / (1.0 - from), left, right);
    piece = left;
  }
  if (from <= 0.0 && to >= 1.0) return part;
  part.segment = segment_from(piece);
  if (to >= 1.0) std::visit([&](auto& each) { each.end = end_of(segment); }, part.segment);
  return part;
}

}  // namespace kerf::drawing
