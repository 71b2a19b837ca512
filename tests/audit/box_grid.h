#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace kerf::audit {

// Finds which of many boxes touch a given box, by a uniform grid with about one cell per box.
class BoxGrid {
 public:
  explicit BoxGrid(std::vector<Eigen::AlignedBox2d> boxes) : boxes_(std::move(boxes)), seen_(boxes_.size(), 0) {
    for (const Eigen::AlignedBox2d& box : boxes_) bounds_.extend(box);
    const double side = std::clamp(std::sqrt(static_cast<double>(boxes_.size())), 1.0, 512.0);
    num_ = static_cast<int>(side);
    cells_.resize(static_cast<std::size_t>(num_) * static_cast<std::size_t>(num_));
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      for_cells(boxes_[i], [&](std::vector<std::size_t>& cell) { cell.push_back(i); });
    }
  }

  // Calls `visit(index)` for each box that touches `box`, once each.
  template <typename Visit>
  void for_touching(const Eigen::AlignedBox2d& box, const Visit& visit) {
    ++round_;
    if (boxes_.empty() || !bounds_.intersects(box)) return;
    for_cells(box, [&](const std::vector<std::size_t>& cell) {
      for (const std::size_t i : cell) {
        if (seen_[i] == round_) continue;
        seen_[i] = round_;
        if (boxes_[i].intersects(box)) visit(i);
      }
    });
  }

 private:
  [[nodiscard]] int column(double value, int axis) const {
    const double size = bounds_.sizes()[axis];
    const double cell = size > 0.0 ? (value - bounds_.min()[axis]) / size * num_ : 0.0;
    return static_cast<int>(std::clamp(cell, 0.0, num_ - 1.0));
  }
  template <typename Visit>
  void for_cells(const Eigen::AlignedBox2d& box, const Visit& visit) {
    for (int y = column(box.min().y(), 1); y <= column(box.max().y(), 1); ++y) {
      for (int x = column(box.min().x(), 0); x <= column(box.max().x(), 0); ++x) {
        visit(cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(num_) + static_cast<std::size_t>(x)]);
      }
    }
  }

  std::vector<Eigen::AlignedBox2d> boxes_;
  Eigen::AlignedBox2d bounds_;
  int num_ = 1;
  std::vector<std::vector<std::size_t>> cells_;
  std::vector<std::uint64_t> seen_;
  std::uint64_t round_ = 0;
};

}  // namespace kerf::audit
