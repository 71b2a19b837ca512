#include "server/core/cut/outline.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <polyclipping/clipper.hpp>

#include "server/base/elementary.h"
#include "server/core/cut/round_offset.h"
#include "server/core/cut/simplify.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;

// Fraction of the tolerance for the chords of arcs at corners and ends; the rest is for leaving out points. -
constexpr double kArcShare = 0.4;

// Factor on the distance of a chord from its arc. RoundOffset rounds the number of chords, so one chord may span 1.5
// times the angle, which makes its distance 1.5^2 times as large.  -
constexpr double kChordRounding = 2.25;

// Bound on Clipper's rounding of offset points and crossings to its grid, and tolerance for straightening chords
// before.  grid units
constexpr double kGridRounding = 2.0;
// Largest coordinates for which Clipper's products fit into 64 bits.  grid units
constexpr double kGridExtent = 1 << 29;

// Most pairs of chords to examine: those whose strips overlap in y.
constexpr std::int64_t kMaxPairsLookedAt = 50'000'000;

// The grid of integers that Clipper works on. It covers everything that the strip may reach.
class Grid {
 public:
  Grid(const FlatCurve& curve, double radius) {
    Eigen::AlignedBox2d box;
    for (const Stroke& stroke : curve.strokes) {
      for (const Vector2d& point : stroke.points) box.extend(point);
    }
    origin_ = box.center();
    spacing_ = (0.5 * box.sizes().maxCoeff() + radius) / kGridExtent;
  }
  [[nodiscard]] double spacing() const { return spacing_; }  // m
  [[nodiscard]] ClipperLib::IntPoint nearest(const Vector2d& at) const {
    return {std::llround((at.x() - origin_.x()) / spacing_), std::llround((at.y() - origin_.y()) / spacing_)};
  }
  [[nodiscard]] Vector2d position(const ClipperLib::IntPoint& at) const {
    return {origin_.x() + spacing_ * static_cast<double>(at.X), origin_.y() + spacing_ * static_cast<double>(at.Y)};
  }

 private:
  Vector2d origin_{0.0, 0.0};
  double spacing_ = 1.0;
};

// Consecutive chords on the grid.
struct Chain {
  ClipperLib::Path points;
  bool is_closed = false;  // a chord joins the last point to the first
};

// Puts the chords of strokes on the grid, each chord only once. Clipper would lose parts of strips whose sides nearly
// coincide. These occur at retraced chords, and at points that rounding moves off a straight line.
class ChordsOnGrid {
 public:
  explicit ChordsOnGrid(const Grid& grid) : grid_(grid) {}

  void add(const Stroke& stroke) {
    Simplification straight(stroke.points, 0.0, kGridRounding * grid_.spacing());
    straight.simplify_between_corners();
    ClipperLib::Path chain;
    bool is_whole = true;
    for (const Vector2d& point : straight.kept_points()) {
      const ClipperLib::IntPoint at = grid_.nearest(point);
      if (chain.empty() || is_new(chain.back(), at)) {
        chain.push_back(at);
      } else if (chain.back() != at) {
        end(chain, false);
        chain.push_back(at);
        is_whole = false;
      }
    }
    end(chain, is_whole);
  }
  [[nodiscard]] const std::vector<Chain>& chains() const { return chains_; }

 private:
  using Point = std::pair<ClipperLib::cInt, ClipperLib::cInt>;

  bool is_new(const ClipperLib::IntPoint& a, const ClipperLib::IntPoint& b) {
    if (a == b) return false;
    const auto [low, high] = std::minmax({Point(a.X, a.Y), Point(b.X, b.Y)});
    return outline_edges_.insert({low, high}).second;
  }
  // Ends a chain. A stroke that has become a single point is made a short chord, as Clipper leaves a gap in the circle
  // around a point.
  void end(ClipperLib::Path& chain, bool is_whole) {
    if (is_whole && chain.size() == 1) chain.emplace_back(chain.front().X + 1, chain.front().Y);
    const bool is_closed = is_whole && chain.size() > 3 && chain.front() == chain.back();
    if (is_closed) chain.pop_back();
    if (chain.size() > 1) chains_.push_back({std::move(chain), is_closed});
    chain.clear();
  }

  const Grid& grid_;
  std::vector<Chain> chains_;
  std::set<std::pair<Point, Point>> outline_edges_;
};

// Returns the angle by which the chain turns at the end of chord i, where the outline has an arc; pi at the end of an
// open chain.  rad
double turn_after(const std::vector<Vector2d>& points, bool is_closed, std::size_t i) {
  const bool is_last = i + 2 == points.size();
  if (is_last && !is_closed) return pi;
  const Vector2d along = points[i + 1] - points[i];
  const Vector2d next = (is_last ? points[1] : points[i + 2]) - points[i + 1];
  return std::abs(arc_tangent(along.x() * next.y() - along.y() * next.x(), along.dot(next)));
}

struct Chord {
  Vector2d low, high;     // corners of the box of the strip around the chord
  double outline_points;  // points of the outline of this strip, before strips are united
};

std::vector<Chord> strips_of_chords(const std::vector<Chain>& chains, const Grid& grid, double radius,
                                    double arc_tolerance) {
  const Vector2d margin = Vector2d::Constant(radius);
  // Uses the formula of RoundOffset.
  const double points_a_turn = pi / arc_cosine(1.0 - std::min(0.25, arc_tolerance / kChordRounding / radius));
  std::vector<Chord> chords;
  for (const Chain& chain : chains) {
    std::vector<Vector2d> points;
    for (const ClipperLib::IntPoint& point : chain.points) points.push_back(grid.position(point));
    if (chain.is_closed) points.push_back(points.front());
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const double start = i == 0 && !chain.is_closed ? pi : 0.0;
      chords.push_back({points[i].cwiseMin(points[i + 1]) - margin, points[i].cwiseMax(points[i + 1]) + margin,
                        2.0 + points_a_turn * (start + turn_after(points, chain.is_closed, i)) / (2.0 * pi)});
    }
  }
  return chords;
}

// Returns true if more than kMaxStripPairs pairs of boxes of strips overlap, or these pairs have more than
// kMaxStripPoints outline points.
bool exceeds_work_budget(std::vector<Chord> chords) {
  std::sort(chords.begin(), chords.end(), [](const Chord& a, const Chord& b) { return a.low.y() < b.low.y(); });
  std::int64_t pairs = 0, looked_at = 0;
  double points = 0.0;
  for (std::size_t i = 0; i < chords.size(); ++i) {
    for (std::size_t j = i + 1; j < chords.size() && chords[j].low.y() <= chords[i].high.y(); ++j) {
      if (++looked_at > kMaxPairsLookedAt) return true;
      if (chords[j].low.x() > chords[i].high.x() || chords[i].low.x() > chords[j].high.x()) continue;
      ++pairs;
      points += chords[i].outline_points + chords[j].outline_points;
      if (pairs > kMaxStripPairs || points > kMaxStripPoints) return true;
    }
  }
  return false;
}

ClipperLib::Paths offset(const std::vector<Chain>& chains, double radius, double arc_tolerance, const Grid& grid) {
  RoundOffset offsetter(radius / grid.spacing(), arc_tolerance / kChordRounding / grid.spacing());
  for (const auto& [points, is_closed] : chains) offsetter.add(points, is_closed);
  return offsetter.united();
}

}  // namespace

Result<Outline> outline(const FlatCurve& curve, double width, double tolerance) {
  const double radius = 0.5 * width;
  const double arc_tolerance = kArcShare * tolerance;
  Outline result;
  if (curve.strokes.empty()) return result;
  const Grid grid(curve, radius);
  ChordsOnGrid laid(grid);
  for (const Stroke& stroke : curve.strokes) laid.add(stroke);
  if (exceeds_work_budget(strips_of_chords(laid.chains(), grid, radius, arc_tolerance))) {
    return resource_exhausted(
        "WIDTH_WORK_BUDGET",
        "too much of the curve lies within its own width: more than " + std::to_string(kMaxStripPairs) +
            " pairs of chords, or " + std::to_string(kMaxStripPoints) +
            " points of their outlines; make it narrower, the tolerance larger, or split the cut into several",
        "cut.width_m");
  }
  const double rounded = arc_tolerance + 2.0 * kGridRounding * grid.spacing();  // bound on arc and rounding errors
  double moved = 0.0;
  for (const ClipperLib::Path& loop : offset(laid.chains(), radius, arc_tolerance, grid)) {
    std::vector<Vector2d> points;
    points.reserve(loop.size() + 1);
    for (const ClipperLib::IntPoint& point : loop) points.push_back(grid.position(point));
    points.push_back(points.front());
    Simplification simplification(points, rounded, std::max(tolerance, rounded));
    simplification.simplify_between_corners();
    std::vector<Vector2d> kept = simplification.kept_points();
    if (kept.size() < 4) continue;  // a hole no wider than the tolerance
    moved = std::max(moved, simplification.moved());
    result.area_m2 += grid.spacing() * grid.spacing() * ClipperLib::Area(loop);
    result.curve.strokes.push_back({std::move(kept)});
  }
  result.curve.deviation_m = curve.deviation_m + rounded + moved;
  return result;
}

bool contains(const std::vector<Stroke>& outline, const Vector2d& at) {
  int winding = 0;
  for (const Stroke& stroke : outline) {
    for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
      const Vector2d a = stroke.points[i] - at;
      const Vector2d b = stroke.points[i + 1] - at;
      if ((a.y() <= 0.0) == (b.y() <= 0.0)) continue;
      const bool is_left = a.x() * b.y() - b.x() * a.y() > 0.0;  // `at` is on the left of the segment from a to b
      if (a.y() <= 0.0 && is_left) ++winding;
      if (b.y() <= 0.0 && !is_left) --winding;
    }
  }
  return winding > 0;
}

}  // namespace kerf::cut
