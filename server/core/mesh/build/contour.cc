#include "server/core/mesh/build/contour.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "server/base/check.h"

namespace kerf::mesh {

using Eigen::Vector2d;

Contour::Contour(std::vector<Vector2d> points, const std::vector<std::size_t>& corners)
    : points_(std::move(points)), is_corner_(points_.size()), turns_(points_.size()) {
  const std::size_t size = points_.size();
  KERF_CHECK(size >= 3, "a contour surrounds something");
  for (const std::size_t corner : corners) is_corner_[corner] = true;
  for (std::size_t i = 0; i < size; ++i) {
    const Vector2d before = points_[i] - points_[(i + size - 1) % size];
    const Vector2d after = points_[(i + 1) % size] - points_[i];
    // Computes 2 tan(turn / 2) with correctly rounded operations only, so that every machine gets the same bits.
    const double half = before.norm() * after.norm() + before.dot(after);
    const double area = std::abs(before.x() * after.y() - before.y() * after.x());
    turns_[i] = half > 0.0 ? 2.0 * area / half : std::numeric_limits<double>::infinity();
    if (turns_[i] > kSharpTurn) is_corner_[i] = true;
    if (is_corner_[i]) turns_[i] = 0.0;
  }
  const auto first = std::find(is_corner_.begin(), is_corner_.end(), true) - is_corner_.begin();
  if (static_cast<std::size_t>(first) < size) {
    std::rotate(points_.begin(), points_.begin() + first, points_.end());
    std::rotate(turns_.begin(), turns_.begin() + first, turns_.end());
    std::rotate(is_corner_.begin(), is_corner_.begin() + first, is_corner_.end());
  }
  stations_.reserve(size + 1);
  stations_.push_back(0.0);
  for (std::size_t i = 0; i < size; ++i) {
    stations_.push_back(stations_.back() + (points_[(i + 1) % size] - points_[i]).norm());
  }
}

std::size_t Contour::chord_at(double station) const {
  const auto after = std::upper_bound(stations_.begin(), stations_.end(), station);
  const auto chord = static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - stations_.begin() - 1, 0));
  return std::min(chord, points_.size() - 1);
}

Vector2d Contour::at(double station) const {
  const std::size_t i = chord_at(station);
  const Vector2d& from = points_[i];
  const Vector2d& to = points_[(i + 1) % points_.size()];
  const double fraction = std::clamp((station - stations_[i]) / (stations_[i + 1] - stations_[i]), 0.0, 1.0);
  return fraction == 1.0 ? to : Vector2d(from + fraction * (to - from));
}

double Contour::snapped(double station, double reach) const {
  const std::size_t i = chord_at(station);
  const double before = station - stations_[i], after = stations_[i + 1] - station;
  if (std::min(before, after) > reach) return station;
  return before <= after ? stations_[i] : stations_[i + 1];
}

}  // namespace kerf::mesh
