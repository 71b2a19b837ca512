#include "server/core/mesh/lip_corner.h"

#include <algorithm>
#include <cmath>

#include "server/core/mesh/lattice_geometry.h"

namespace kerf::mesh {

using Eigen::Vector2d;

namespace {

constexpr double kCosStraight = 0.9;    // a lip that turns more than about 26 degrees at a point ends there
constexpr int kMaxEdges = 8;            // most edges along which a lip is followed to a corner
constexpr double kSameDistance = 1e-3;  // -; relative difference of distances that count as equal

double cos_between(const Vector2d& u, const Vector2d& v) {
  return u.dot(v) / std::sqrt(u.squaredNorm() * v.squaredNorm());
}

}  // namespace

double LipCorners::sharpest(PointId p) {
  mesh_.fan_around(p, fan_);
  double cos_sharpest = kCosSharp;
  // Sweeps each solid sector from one fixed edge to the next. Stops at the first edge, fixed or not, at 60 degrees or
  // more from the start.
  const std::size_t size = fan_.size();
  for (std::size_t first = 0; first < size; ++first) {
    const int k = mesh_.corner_of(fan_[first], p);
    if (!mesh_.is_solid(fan_[first]) || !mesh_.is_fixed(fan_[first], previous_corner(k))) continue;
    // Measures in the facet of the first triangle, which holds the whole sector: edges between facets are fixed.
    const Vector2d start =
        mesh_.at_rest(fan_[first], difference(mesh_.at(p), mesh_.at(mesh_.points(fan_[first])[next_corner(k)])));
    for (std::size_t step = 0; step < size; ++step) {
      const TriangleId t = fan_[(first + step) % size];
      const int corner = mesh_.corner_of(t, p);
      const Vector2d end =
          mesh_.at_rest(fan_[first], difference(mesh_.at(p), mesh_.at(mesh_.points(t)[previous_corner(corner)])));
      const double cos_angle = cos_between(start, end);
      if (cos_angle < kCosSharp || start.x() * end.y() - start.y() * end.x() <= 0.0) break;
      if (!mesh_.is_fixed(t, next_corner(corner))) continue;
      cos_sharpest = std::max(cos_sharpest, cos_angle);
      break;
    }
  }
  return cos_sharpest;
}

void LipCorners::find_fixed_neighbours(PointId p, std::vector<PointId>& neighbours) {
  neighbours.clear();
  mesh_.fan_around(p, fan_);
  for (const TriangleId t : fan_) {
    const int k = mesh_.corner_of(t, p);
    if (mesh_.is_fixed(t, previous_corner(k))) neighbours.push_back(mesh_.points(t)[next_corner(k)]);
  }
}

void LipCorners::follow_lips(PointId p, std::vector<Reach>& reached) {
  reached.clear();
  find_fixed_neighbours(p, ends_);
  for (const PointId end : ends_) {
    PointId previous = p;
    PointId current = end;
    for (int edge = 0; edge < kMaxEdges && current != kNone; ++edge) {
      reached.push_back({current, difference(mesh_.at(p), mesh_.at(current)).norm(), edge + 1});
      const Vector2d direction = difference(mesh_.at(previous), mesh_.at(current));
      find_fixed_neighbours(current, onward_);
      previous = current;
      current = kNone;
      for (const PointId next : onward_) {
        if (cos_between(direction, difference(mesh_.at(previous), mesh_.at(next))) > kCosStraight) {
          current = next;
          break;
        }
      }
    }
  }
}

int LipCorners::edges_to_sharp_corner(PointId p, PointId q) {
  if (!mesh_.has_fixed_edge(p) || !mesh_.has_fixed_edge(q)) return 0;
  follow_lips(p, from_p_);
  follow_lips(q, from_q_);
  for (const Reach& a : from_p_) {
    for (const Reach& b : from_q_) {
      if (a.point != b.point || std::abs(a.distance - b.distance) > kSameDistance * a.distance) continue;
      const Vector2d to_p = difference(mesh_.at(a.point), mesh_.at(p));
      const Vector2d to_q = difference(mesh_.at(a.point), mesh_.at(q));
      const double cos_angle = cos_between(to_p, to_q);
      if (cos_angle > kCosSharp && cos_angle < 1.0 - 1e-9) return std::max(a.edges, b.edges);
    }
  }
  return 0;
}

double LipCorners::split_fraction(PointId a, PointId b, double length) {
  const bool sharp_a = is_sharp(a);
  if (sharp_a == is_sharp(b)) return 0.5;
  int exponent = 0;
  std::frexp(length * (2.0 / 3.0), &exponent);
  const double shell = std::ldexp(0.5, exponent) / length;  // the largest power of two up to 2/3 of the length
  return sharp_a ? shell : 1.0 - shell;
}

}  // namespace kerf::mesh
