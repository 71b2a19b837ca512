#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace kerf::mesh {

// A closed curve, given as a fine polygon. Places on it are named by their "station": the arc length from its first
// point, m. Station 0 is at a corner if the curve has any.
class Contour {
 public:
  // `points`: m, at least 3, neighbours different; an edge joins the last to the first. `corners`: indices into points,
  // sorted. Points where the polygon turns by more than kSharpTurn become corners as well.
  Contour(std::vector<Eigen::Vector2d> points, const std::vector<std::size_t>& corners);

  static constexpr double kSharpTurn = 0.2;  // rad

  [[nodiscard]] std::size_t num_points() const { return points_.size(); }
  [[nodiscard]] const Eigen::Vector2d& point(std::size_t i) const { return points_[i]; }  // m
  [[nodiscard]] double station(std::size_t i) const { return stations_[i]; }  // m; i = num_points(): length()
  [[nodiscard]] double length() const { return stations_.back(); }            // m
  [[nodiscard]] bool is_corner(std::size_t i) const { return is_corner_[i % points_.size()]; }
  // Absolute angle by which the polygon turns at point i, to 0.4 %; 0 at a corner.  rad
  [[nodiscard]] double turn(std::size_t i) const { return turns_[i % points_.size()]; }

  // Returns the chord that holds `station`, by the index i of its start; chord i joins points i and i + 1. At a point,
  // this is the chord that begins there.
  [[nodiscard]] std::size_t chord_at(double station) const;
  // Returns the place at a station in [0, length()], m.
  [[nodiscard]] Eigen::Vector2d at(double station) const;
  // Returns the station of the nearer end of the chord at `station`, if it is within `reach` (m). Returns `station`
  // itself if both ends are farther.
  [[nodiscard]] double snapped(double station, double reach) const;

 private:
  std::vector<Eigen::Vector2d> points_;
  std::vector<bool> is_corner_;
  std::vector<double> turns_;
  std::vector<double> stations_;  // of each point, then the length of the whole curve
};

}  // namespace kerf::mesh
