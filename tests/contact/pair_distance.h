#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "server/core/contact/feature_pair.h"

// Distances of pairs as the least of all candidates, in more digits than the code that is tested.
namespace kerf::contact {

using WidePoint = Eigen::Matrix<long double, 3, 1>;

inline long double wide_to_segment(const WidePoint& p, const WidePoint& a, const WidePoint& b) {
  const WidePoint ab = b - a;
  const long double square = ab.squaredNorm();
  const long double t = square > 0.0L ? std::clamp((p - a).dot(ab) / square, 0.0L, 1.0L) : 0.0L;
  return (p - a - t * ab).norm();
}

// Returns the distance of both sides of a pair, m.
inline double wide_distance(FeaturePair::Kind kind, const PairPositions& positions) {
  std::array<WidePoint, 4> x;
  for (std::size_t i = 0; i < 4; ++i) x[i] = positions[i].cast<long double>();
  if (kind == FeaturePair::Kind::kVertexTriangle) {
    long double least = std::min(
        {wide_to_segment(x[0], x[1], x[2]), wide_to_segment(x[0], x[2], x[3]), wide_to_segment(x[0], x[3], x[1])});
    const WidePoint ab = x[2] - x[1], ac = x[3] - x[1], ap = x[0] - x[1], normal = ab.cross(ac);
    const long double square = normal.squaredNorm();
    if (square > 0.0L) {
      const long double v = ap.cross(ac).dot(normal) / square, w = ab.cross(ap).dot(normal) / square;
      if (v >= 0.0L && w >= 0.0L && v + w <= 1.0L) least = std::min(least, (ap - v * ab - w * ac).norm());
    }
    return static_cast<double>(least);
  }
  long double least = std::min({wide_to_segment(x[0], x[2], x[3]), wide_to_segment(x[1], x[2], x[3]),
                                wide_to_segment(x[2], x[0], x[1]), wide_to_segment(x[3], x[0], x[1])});
  const WidePoint d1 = x[1] - x[0], d2 = x[3] - x[2], r = x[2] - x[0], normal = d1.cross(d2);
  const long double square = normal.squaredNorm();
  if (square > 0.0L) {
    const long double s = r.cross(d2).dot(normal) / square, t = r.cross(d1).dot(normal) / square;
    if (s >= 0.0L && s <= 1.0L && t >= 0.0L && t <= 1.0L) least = std::min(least, (r + t * d2 - s * d1).norm());
  }
  return static_cast<double>(least);
}

}  // namespace kerf::contact
