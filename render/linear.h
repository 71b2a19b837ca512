#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "render/renderer.h"

// Provides the linear algebra of views and shapes.
namespace kerf::render {

inline Vec3 operator+(Vec3 a, Vec3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3 operator-(Vec3 a, Vec3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3 operator*(double s, Vec3 a) {
  return {s * a.x, s * a.y, s * a.z};
}
inline double dot(Vec3 a, Vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(Vec3 a) {
  return std::hypot(a.x, a.y, a.z);
}
inline Vec3 normalized(Vec3 a) {
  return (1.0 / norm(a)) * a;
}
inline bool is_finite(Vec3 a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

// Returns some unit vector perpendicular to the unit vector `axis`.
inline Vec3 perpendicular(Vec3 axis) {
  const Vec3 other = std::abs(axis.z) < 0.9 ? Vec3{0.0, 0.0, 1.0} : Vec3{1.0, 0.0, 0.0};
  return normalized(cross(axis, other));
}

// Represents a 4x4 matrix, column-major as in OpenGL: entry (row, column) is at 4*column + row.
struct Matrix4 {
  std::array<double, 16> entries{};

  double& at(std::size_t row, std::size_t column) { return entries[4 * column + row]; }
  [[nodiscard]] double at(std::size_t row, std::size_t column) const { return entries[4 * column + row]; }
};

inline Matrix4 operator*(const Matrix4& a, const Matrix4& b) {
  Matrix4 product;
  for (std::size_t column = 0; column < 4; ++column) {
    for (std::size_t row = 0; row < 4; ++row) {
      for (std::size_t k = 0; k < 4; ++k) product.at(row, column) += a.at(row, k) * b.at(k, column);
    }
  }
  return product;
}

}  // namespace kerf::render
