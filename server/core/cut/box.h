#pragma once

#include <Eigen/Core>

namespace kerf::cut {

// An axis-aligned box in material coordinates.  m
struct Box {
  Eigen::Vector2d low{0.0, 0.0};
  Eigen::Vector2d high{0.0, 0.0};

  [[nodiscard]] bool contains(const Eigen::Vector2d& point) const {
    return (point.array() >= low.array()).all() && (point.array() <= high.array()).all();
  }
};

}  // namespace kerf::cut
