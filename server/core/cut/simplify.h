#pragma once

#include <cstddef>
#include <vector>

#include "server/core/cut/curve.h"
#include "server/core/cut/path_scale.h"

namespace kerf::cut {

// Represents a flattened curve with two bounds on its distance from the original. One is in metres, the other is
// relative to the tolerance, which differs from place to place.
struct ScaledCurve {
  FlatCurve curve;
  double deviation_of_tolerance = 0.0;  // -; largest ratio of the distance to the tolerance at its place
};

// Leaves out points of one polyline by the algorithm of Douglas and Peucker (1973), within the deviation allowed to
// each of its segments. The bound holds both ways: distance to a chord is convex along a segment. The nearest point of
// the chord runs over all of it as one follows the path.
class Simplification {
 public:
  // `points`: at least 2; must outlive this. `flattened`: bound on their distance from the curve, m.
  Simplification(const std::vector<Eigen::Vector2d>& points, double flattened, const PathScale& scale);
  // With the same tolerance (m) everywhere, all of it for flattening.
  Simplification(const std::vector<Eigen::Vector2d>& points, double flattened, double tolerance);

  // Keeps points `first` and `last`, and those in between that the tolerance needs.
  void simplify_stretch(std::size_t first, std::size_t last);
  // Does so between each two corners: points where the path turns by more than 20 degrees.
  void simplify_between_corners();

  [[nodiscard]] std::vector<Eigen::Vector2d> kept_points() const;
  // Returns the largest distance of a point left out from its chord, m.
  [[nodiscard]] double moved() const { return moved_; }
  // Returns the largest value of (flattened + such a distance) / tolerance, with the tolerance of the point's segment.
  [[nodiscard]] double of_tolerance() const { return of_tolerance_; }

 private:
  const std::vector<Eigen::Vector2d>& points_;
  double flattened_;
  std::vector<bool> kept_;
  std::vector<double> room_;       // of each segment, m
  std::vector<double> tolerance_;  // of each segment, m
  double moved_ = 0.0;             // m
  double of_tolerance_ = 0.0;
};

// Leaves out points of a curve that was flattened to the least tolerance anywhere, where the tolerance is larger. A
// curve of straight pieces (deviation 0), and any curve where one length holds everywhere, is returned as it is.
ScaledCurve simplify(const FlatCurve& curve, const PathScale& scale);

}  // namespace kerf::cut
