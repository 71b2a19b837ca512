#pragma once

#include <cstddef>
#include <vector>

#include "server/core/cut/curve.h"
#include "server/core/cut/path_scale.h"

namespace kerf::cut {

// A flattened curve with two bounds on its distance from the original: deviation_m of the curve in metres, and one
// relative to the local tolerance.
struct ScaledCurve {
  FlatCurve curve;
  double deviation_of_tolerance = 0.0;  // -; largest ratio of the distance to the local tolerance
};

// Leaves out points of one polyline by the algorithm of Douglas and Peucker (1973), within the deviation allowed to
// each of its segments. The bound holds both ways. The distance of a segment's points from the chord is largest at an
// end of the segment. And every point of the chord is the nearest one to some point of the polyline.
class Simplification {
 public:
  // `points`: at least 2; must outlive this. `flattened`: bound on the distance of this polyline from the curve, m.
  Simplification(const std::vector<Eigen::Vector2d>& points, double flattened, const PathScale& scale);
  // Uses the same tolerance (m) everywhere, and all of it.
  Simplification(const std::vector<Eigen::Vector2d>& points, double flattened, double tolerance);

  // Keeps points `first` and `last`, and those in between that the tolerance requires.
  void simplify_stretch(std::size_t first, std::size_t last);
  // Simplifies each stretch between two corners, which are points where the polyline turns by more than 20 degrees.
  void simplify_between_corners();

  [[nodiscard]] std::vector<Eigen::Vector2d> kept_points() const;
  // Returns the largest distance of a point left out from its chord, m.
  [[nodiscard]] double moved() const { return moved_; }
  // Returns the largest value of (flattened + distance of a point left out) / tolerance, with the tolerance of the
  // point's segment.
  [[nodiscard]] double of_tolerance() const { return of_tolerance_; }

 private:
  const std::vector<Eigen::Vector2d>& points_;
  double flattened_;
  std::vector<bool> kept_;
  std::vector<double> room_;       // deviation that leaving out points may add, for each segment, m
  std::vector<double> tolerance_;  // tolerance at each segment, m
  double moved_ = 0.0;             // m
  double of_tolerance_ = 0.0;
};

// Leaves out points where the local tolerance is larger than the least one, to which the curve was flattened. Curves of
// straight pieces (deviation_m 0), and all curves on a sheet of uniform edge length, are returned as they are.
ScaledCurve simplify(const FlatCurve& curve, const PathScale& scale);

}  // namespace kerf::cut
