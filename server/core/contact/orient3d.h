#pragma once

#include <cmath>

#include <Eigen/Core>

namespace kerf::contact {

// Sides of planes through points in space, exactly, whatever the processor. Every coordinate must be 0 or have a
// magnitude from kLeastCoordinate to kMostCoordinate, so that no product of three leaves the range of a double.
inline constexpr double kLeastCoordinate = 0x1.0p-300;  // m
inline constexpr double kMostCoordinate = 0x1.0p+300;   // m

// Returns on which side of the plane (a, b, c) the point d lies: the sign, -1, 0 or 1, of (b - a) x (c - a) . (d - a).
// It is 1 on the side from which a, b, c turn counter-clockwise, and 0 for a, b, c on one line. Computed from sums of
// doubles without rounding (Shewchuk 1997, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates"), in some 0.3 us.
int orient3d_exact(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                   const Eigen::Vector3d& d);

// The plane through three points in doubles, with the bound on rounding that tells which of its answers are exact.
class FilteredPlane {
 public:
  static constexpr int kUnsure = 2;

  FilteredPlane(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) : a_(a) {
    const Eigen::Vector3d u = b - a, v = c - a;
    const Eigen::Vector3d plus(u.y() * v.z(), u.z() * v.x(), u.x() * v.y());
    const Eigen::Vector3d minus(u.z() * v.y(), u.x() * v.z(), u.y() * v.x());
    normal_ = plus - minus;
    size_ = plus.cwiseAbs() + minus.cwiseAbs();
  }

  // Returns orient3d_exact(a, b, c, d), or kUnsure if rounding might have changed the sign.
  [[nodiscard]] int side(const Eigen::Vector3d& d) const {
    // The error is below 8 units of 2^-53 of `scale`; twice that covers the rounding of `scale` too. What underflows is
    // far below kTiny.
    constexpr double kBound = 0x1.0p-49, kTiny = 0x1.0p-1000;
    const Eigen::Vector3d w = d - a_;
    const double value = normal_.x() * w.x() + normal_.y() * w.y() + normal_.z() * w.z();
    const double scale = size_.x() * std::abs(w.x()) + size_.y() * std::abs(w.y()) + size_.z() * std::abs(w.z());
    const double bound = kBound * scale + kTiny;
    if (value > bound) return 1;
    return value < -bound ? -1 : kUnsure;
  }
  // (b - a) x (c - a), m^2, rounded.
  [[nodiscard]] const Eigen::Vector3d& normal() const { return normal_; }

 private:
  Eigen::Vector3d a_, normal_, size_;
};

// Returns the same as orient3d_exact(), almost always from doubles alone.
inline int orient3d(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                    const Eigen::Vector3d& d) {
  const int side = FilteredPlane(a, b, c).side(d);
  return side == FilteredPlane::kUnsure ? orient3d_exact(a, b, c, d) : side;
}

}  // namespace kerf::contact
