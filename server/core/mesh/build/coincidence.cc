#include "server/core/mesh/build/coincidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "server/base/interruption.h"

namespace kerf::mesh {
namespace {

using Cell = std::array<std::int64_t, 3>;

constexpr double kCells = 0x1p20;  // most cells along each axis

// Sorts points into cells that are at least as wide as the tolerance.
class PlaceFinder {
 public:
  PlaceFinder(std::span<const Eigen::Vector3d> points, double tolerance)
      : points_(points), tolerance_(tolerance), groups_(points.size()) {}

  std::vector<std::int32_t> run() {
    double reach = 0.0;
    for (const Eigen::Vector3d& point : points_) {
      if (point.allFinite()) reach = std::max(reach, point.cwiseAbs().maxCoeff());
    }
    width_ = std::max({2.0 * tolerance_, 2.0 * reach / kCells, 1e-300});
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (points_[i].allFinite()) order_.emplace_back(cell_of(points_[i]), static_cast<std::int32_t>(i));
    }
    std::sort(order_.begin(), order_.end());
    for (const auto& [cell, i] : order_) {
      interruption_point();
      join_near(i);
    }
    std::vector<std::int32_t> firsts;
    firsts.reserve(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) firsts.push_back(groups_.first_of(static_cast<std::int32_t>(i)));
    return firsts;
  }

 private:
  [[nodiscard]] Cell cell_of(const Eigen::Vector3d& at) const {
    Cell cell{};
    for (int axis = 0; axis < 3; ++axis) cell[axis] = static_cast<std::int64_t>(std::floor(at[axis] / width_));
    return cell;
  }

  // Joins a point with those after it in the order that are near.
  void join_near(std::int32_t i) {
    const Eigen::Vector3d reach = Eigen::Vector3d::Constant(tolerance_);
    const Cell low = cell_of(points_[i] - reach), high = cell_of(points_[i] + reach);
    for (std::int64_t x = low[0]; x <= high[0]; ++x) {
      for (std::int64_t y = low[1]; y <= high[1]; ++y) {
        const std::pair<Cell, std::int32_t> first{{x, y, low[2]}, 0};
        for (auto at = std::lower_bound(order_.begin(), order_.end(), first); at != order_.end(); ++at) {
          if (at->first > Cell{x, y, high[2]}) break;
          const bool is_near = at->second < i && (points_[at->second] - points_[i]).norm() <= tolerance_;
          if (is_near) groups_.join(at->second, i);
        }
      }
    }
  }

  std::span<const Eigen::Vector3d> points_;
  double tolerance_;
  double width_ = 1.0;  // of a cell
  std::vector<std::pair<Cell, std::int32_t>> order_;
  Groups groups_;
};

}  // namespace

Groups::Groups(std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) parent_.push_back(static_cast<std::int32_t>(i));
}

void Groups::join(std::int32_t a, std::int32_t b) {
  a = first_of(a);
  b = first_of(b);
  parent_[std::max(a, b)] = std::min(a, b);
}

std::int32_t Groups::first_of(std::int32_t a) {
  while (parent_[a] != a) {
    parent_[a] = parent_[parent_[a]];
    a = parent_[a];
  }
  return a;
}

std::vector<std::int32_t> first_at_place(std::span<const Eigen::Vector3d> points, double tolerance) {
  return PlaceFinder(points, tolerance).run();
}

}  // namespace kerf::mesh
