#include "server/core/contact/feature_pair.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace kerf::contact {
namespace {

using mesh::kNone;
using mesh::VertexId;

void finish(const PairPositions& x, Separation& result) {
  Eigen::Vector3d way = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 4; ++i) way += result.weights[i] * x[i];
  result.distance = way.norm();
  if (result.distance > 0.0) result.normal = way / result.distance;
}

// Returns the weights of the point of a triangle that is nearest to p. Corners may coincide.
std::array<double, 3> nearest_on_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                          const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return {1.0, 0.0, 0.0};
  const Eigen::Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return {0.0, 1.0, 0.0};
  // Products of vectors, as those of d1 to d6 lose all digits in slivers.
  const Eigen::Vector3d cp = p - c, normal = ab.cross(ac);
  const double vc = normal.dot(ap.cross(bp));
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3) {
    const double v = d1 / (d1 - d3);
    return {1.0 - v, v, 0.0};
  }
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return {0.0, 0.0, 1.0};
  const double vb = normal.dot(cp.cross(ap));
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6) {
    const double w = d2 / (d2 - d6);
    return {1.0 - w, 0.0, w};
  }
  const double va = normal.dot(bp.cross(cp));
  const double to_c = d4 - d3, to_b = d5 - d6;
  if (va <= 0.0 && to_c >= 0.0 && to_b >= 0.0 && to_c + to_b > 0.0) {
    const double w = to_c / (to_c + to_b);
    return {0.0, 1.0 - w, w};
  }
  if (!(va + vb + vc > 0.0)) return {1.0, 0.0, 0.0};
  const double scale = 1.0 / (va + vb + vc);
  const double v = vb * scale, w = vc * scale;
  return {1.0 - v - w, v, w};
}

// Returns the places, from 0 to 1, of the nearest points on two segments.
std::array<double, 2> nearest_on_segments(const PairPositions& x) {
  constexpr double kParallel = 1e-15;  // -, least denominator over its largest value
  const Eigen::Vector3d d1 = x[1] - x[0], d2 = x[3] - x[2], r = x[0] - x[2];
  const double a = d1.squaredNorm(), e = d2.squaredNorm(), f = d2.dot(r), c = d1.dot(r), b = d1.dot(d2);
  const auto clamp = [](double value) { return std::clamp(value, 0.0, 1.0); };
  if (!(a > 0.0)) return {0.0, e > 0.0 ? clamp(f / e) : 0.0};
  if (!(e > 0.0)) return {clamp(-c / a), 0.0};
  const double denominator = std::max(a * e - b * b, kParallel * a * e);  // 0 where edges are shorter than 1e-80 m
  double s = denominator > 0.0 ? clamp((b * f - c * e) / denominator) : 0.0;
  const double t = clamp((b * s + f) / e);
  s = clamp((b * t - c) / a);
  return {s, t};
}

// Returns true if `way` leads along `normal`, a unit vector, by more than rounding.
bool leads_along(const Eigen::Vector3d& normal, const Eigen::Vector3d& way) {
  constexpr double kRounding = 1e-9;  // -
  const double along = normal.dot(way);
  return along > 0.0 && along * along > kRounding * kRounding * way.squaredNorm();
}

// Returns the only corner with a weight.
VertexId nearest_corner(const SheetFeatures::Triangle& triangle, const std::array<double, 4>& weights) {
  const auto found = std::find_if(weights.begin() + 1, weights.end(), [](double weight) { return weight != 0.0; });
  return triangle.vertices[static_cast<std::size_t>(found - weights.begin() - 1)];
}

}  // namespace

Separation separation(FeaturePair::Kind kind, const PairPositions& x) {
  Separation result;
  if (kind == FeaturePair::Kind::kVertexTriangle) {
    const std::array<double, 3> weights = nearest_on_triangle(x[0], x[1], x[2], x[3]);
    result.weights = {1.0, -weights[0], -weights[1], -weights[2]};
  } else {
    const auto [s, t] = nearest_on_segments(x);
    result.weights = {1.0 - s, s, t - 1.0, -t};
  }
  finish(x, result);
  return result;
}

bool stands_for_separation(const SheetFeatures& features, const FeaturePair& pair, const Separation& separation) {
  const std::array<double, 4>& w = separation.weights;
  if (pair.kind == FeaturePair::Kind::kEdgeEdge) return w[0] > 0.0 && w[1] > 0.0 && w[2] < 0.0 && w[3] < 0.0;
  const SheetFeatures::Triangle& triangle = features.triangles[static_cast<std::size_t>(pair.b)];
  switch (std::count(w.begin() + 1, w.end(), 0.0)) {
    case 0:
      return true;
    case 1:
      return triangle.owns_edge[static_cast<std::size_t>(std::find(w.begin() + 1, w.end(), 0.0) - w.begin() - 1)];
    default: {
      const VertexId v = nearest_corner(triangle, w);
      return pair.a < v && features.triangles_of(v).front() == pair.b;
    }
  }
}

bool is_in_cones(const SheetFeatures& features, const FeaturePair& pair, const Separation& separation,
                 const linear::VertexField& x) {
  if (pair.kind == FeaturePair::Kind::kEdgeEdge) return true;
  const auto at = [&x](VertexId v) -> Eigen::Vector3d { return x.col(v); };
  const std::array<double, 4>& w = separation.weights;
  const SheetFeatures::Triangle& triangle = features.triangles[static_cast<std::size_t>(pair.b)];
  const auto num_zero = std::count(w.begin() + 1, w.end(), 0.0);
  if (num_zero == 0) return true;
  if (num_zero == 1) {
    // On an edge: the other triangle at that edge must not be nearer.
    const auto corner = static_cast<std::size_t>(std::find(w.begin() + 1, w.end(), 0.0) - w.begin() - 1);
    const VertexId other = triangle.across[corner];
    const Eigen::Vector3d from = at(triangle.vertices[(corner + 1) % 3]);
    const Eigen::Vector3d edge = at(triangle.vertices[(corner + 2) % 3]) - from;
    const auto is_nearer = [&](VertexId third) {
      const Eigen::Vector3d out = at(third) - from;
      return leads_along(separation.normal, out - out.dot(edge) / edge.squaredNorm() * edge);
    };
    return (other == kNone || !is_nearer(other)) && !is_nearer(triangle.vertices[corner]);
  }
  const auto has_nearer = [&](VertexId v, const Eigen::Vector3d& towards) {
    const Eigen::Vector3d here = at(v);
    const std::span<const VertexId> neighbours = features.neighbours_of(v);
    return std::any_of(neighbours.begin(), neighbours.end(),
                       [&](VertexId neighbour) { return leads_along(towards, at(neighbour) - here); });
  };
  return !has_nearer(nearest_corner(triangle, w), separation.normal) && !has_nearer(pair.a, -separation.normal);
}

double gap_along(std::size_t num_a, const Eigen::Vector3d& normal, const PairPositions& x) {
  double least_a = std::numeric_limits<double>::infinity();
  double most_b = -least_a;
  for (std::size_t i = 0; i < 4; ++i) {
    const double height = normal.dot(x[i] - x[3]);
    if (i < num_a) {
      least_a = std::min(least_a, height);
    } else {
      most_b = std::max(most_b, height);
    }
  }
  return least_a - most_b;
}

bool stays_apart(FeaturePair::Kind kind, const PairPositions& from, const PairPositions& to, double gap) {
  constexpr double kShare = 0.9;  // -, part of the distance to the gap that a step may use up
  constexpr double kLeft = 1e-3;  // -, part of that distance at first at which steps would only get shorter
  constexpr int kMostSteps = 100;
  const std::size_t num_a = kind == FeaturePair::Kind::kVertexTriangle ? 1 : 2;
  std::array<Eigen::Vector3d, 4> way;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    way[i] = to[i] - from[i];
    mean += 0.25 * way[i];
  }
  double most_a = 0.0, most_b = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    way[i] -= mean;
    double& most = i < num_a ? most_a : most_b;
    most = std::max(most, way[i].norm());
  }
  const double longest = most_a + most_b;  // m, bound of the relative motion
  double time = 0.0;                       // -, part of the way
  PairPositions x = from;
  double least_room = 0.0;  // m
  for (int step = 0; step < kMostSteps; ++step) {
    const double room = separation(kind, x).distance - gap;
    if (!(room > least_room)) return false;
    if (step == 0) least_room = kLeft * room;
    if (time >= 1.0 || longest * (1.0 - time) < room) return true;
    time = std::min(1.0, time + kShare * room / longest);
    for (std::size_t i = 0; i < 4; ++i) x[i] = from[i] + time * way[i];
  }
  return false;
}

}  // namespace kerf::contact
