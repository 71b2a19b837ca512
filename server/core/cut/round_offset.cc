#include "server/core/cut/round_offset.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <Eigen/Core>

#include "server/base/elementary.h"

namespace kerf::cut {

namespace {

using ClipperLib::IntPoint;
using Eigen::Vector2d;

constexpr double kTurn = 2.0 * std::numbers::pi;  // rad

// Returns the unit normal to the right of a chord.
Vector2d right_of(const IntPoint& from, const IntPoint& to) {
  const auto dx = static_cast<double>(to.X - from.X);
  const auto dy = static_cast<double>(to.Y - from.Y);
  const double scale = 1.0 / std::sqrt(dx * dx + dy * dy);
  return {dy * scale, -dx * scale};
}

ClipperLib::cInt nearest_whole(double value) {
  return static_cast<ClipperLib::cInt>(value < 0.0 ? value - 0.5 : value + 0.5);
}

IntPoint shifted(const IntPoint& at, const Vector2d& normal, double distance) {
  return {nearest_whole(static_cast<double>(at.X) + normal.x() * distance),
          nearest_whole(static_cast<double>(at.Y) + normal.y() * distance)};
}

}  // namespace

RoundOffset::RoundOffset(double radius, double arc_tolerance) : radius_(radius) {
  constexpr double kLargestTolerance = 0.25;  // radii
  const double tolerance = std::min(arc_tolerance, kLargestTolerance * radius);
  const double chords = std::min(std::numbers::pi / arc_cosine(1.0 - tolerance / radius), radius * std::numbers::pi);
  sine_ = sine(kTurn / chords);
  cosine_ = cosine(kTurn / chords);
  chords_a_radian_ = chords / kTurn;
}

void RoundOffset::add(const ClipperLib::Path& chain, bool is_closed) {
  ClipperLib::Path loop = chain;
  if (is_closed) {
    if (!ClipperLib::Orientation(loop)) ClipperLib::ReversePath(loop);
    follow(loop, 0);
    ClipperLib::ReversePath(loop);
    follow(loop, 0);
  } else {
    for (std::size_t i = chain.size() - 1; i-- > 1;) loop.push_back(chain[i]);
    follow(loop, 1);
  }
}

void RoundOffset::follow(const ClipperLib::Path& loop, std::size_t first) {
  ClipperLib::Path side;
  const std::size_t size = loop.size();
  const auto point = [&](std::size_t i) -> const IntPoint& { return loop[i % size]; };
  Vector2d before = right_of(point(first + size - 1), point(first));
  for (std::size_t i = first; i < first + size; ++i) {
    const IntPoint& at = point(i);
    const IntPoint& last = point(i + size - 1);
    const IntPoint& next = point(i + 1);
    if (last == next) before = right_of(last, at);  // the end of an open chain
    const Vector2d after = right_of(at, next);
    const double cross = before.x() * after.y() - after.x() * before.y();
    const double dot = before.x() * after.x() + after.y() * before.y();
    side.push_back(shifted(at, before, radius_));
    // Both ends of the arc are about one grid point. Turns add up until they matter.
    if (std::abs(cross * radius_) < 1.0 && dot > 0.0) continue;
    if (cross < 0.0) {  // the union removes the loop that this point makes
      side.push_back(at);
    } else {
      const double angle = std::abs(arc_tangent(std::min(cross, 1.0), dot));
      Vector2d normal = before;
      for (ClipperLib::cInt chord = nearest_whole(chords_a_radian_ * angle); chord > 1; --chord) {
        normal = Vector2d{normal.x() * cosine_ - sine_ * normal.y(), normal.x() * sine_ + normal.y() * cosine_};
        side.push_back(shifted(at, normal, radius_));
      }
    }
    side.push_back(shifted(at, after, radius_));
    before = after;
  }
  sides_.push_back(std::move(side));
}

ClipperLib::Paths RoundOffset::united() const {
  ClipperLib::Clipper clipper;
  clipper.AddPaths(sides_, ClipperLib::ptSubject, true);
  ClipperLib::Paths loops;
  clipper.Execute(ClipperLib::ctUnion, loops, ClipperLib::pftPositive, ClipperLib::pftPositive);
  return loops;
}

}  // namespace kerf::cut
