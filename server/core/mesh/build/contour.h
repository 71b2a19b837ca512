#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace kerf::mesh {

// A closed curve as a fine polygon, by its arc length ("station"). Where it has corners, station 0 is one.
class Contour {
 public:
  // `points`: m, at least 3, the last joins the first, neighbours differ. `corners`: indices of points, sorted; a point
  // where the polygon turns by more than kSharpTurn is one in any case.
  Contour(std::vector<Eigen::Vector2d> points, const std::vector<std::size_t>& corners);

  static constexpr double kSharpTurn = 0.2;  // rad

  [[nodiscard]] std::size_t num_points() const { return points_.size(); }
  [[nodiscard]] const Eigen::Vector2d& point(std::size_t i) const { return points_[i]; }  // m
  [[nodiscard]] double station(std::size_t i) const { return stations_[i]; }  // m; of point i, num_points(): length()
  [[nodiscard]] double length() const { return stations_.back(); }            // m
  [[nodiscard]] bool is_corner(std::size_t i) const { return is_corner_[i % points_.size()]; }
  // Angle by which it turns at a point that is no corner, either way, to 0.4 %; 0 at a corner.  rad
  [[nodiscard]] double turn(std::size_t i) const { return turns_[i % points_.size()]; }

  // The chord, from point i to the next, on which `station` lies; the later of two.
  [[nodiscard]] std::size_t chord_at(double station) const;
  // m; of a station in [0, length()].
  [[nodiscard]] Eigen::Vector2d at(double station) const;
  // The station of the point nearest along the curve, if it is within `reach` (m), else `station` itself.
  [[nodiscard]] double snapped(double station, double reach) const;

 private:
  std::vector<Eigen::Vector2d> points_;
  std::vector<bool> is_corner_;
  std::vector<double> turns_;
  std::vector<double> stations_;  // one more than points
};

}  // namespace kerf::mesh
