#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

// Intersections of triangles whose corners have whole coordinates, in integers alone.
namespace kerf::contact {

__extension__ using Wide = __int128;

using WholePoint = std::array<std::int64_t, 3>;  // each at most 2^9 in magnitude
using WholeTriangle = std::array<WholePoint, 3>;

inline std::array<Wide, 3> cross(const std::array<Wide, 3>& a, const std::array<Wide, 3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Wide dot(const std::array<Wide, 3>& a, const std::array<Wide, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline std::array<Wide, 3> from_to(const WholePoint& a, const WholePoint& b) {
  return {Wide{b[0]} - a[0], Wide{b[1]} - a[1], Wide{b[2]} - a[2]};
}
inline std::array<Wide, 3> normal_of(const WholeTriangle& t) {
  return cross(from_to(t[0], t[1]), from_to(t[0], t[2]));
}

// A quotient with a positive divisor.
struct Fraction {
  Wide over = 0, under = 1;
  friend bool operator<(const Fraction& a, const Fraction& b) { return a.over * b.under < b.over * a.under; }
};

struct Interval {
  Fraction low, high;
};

// Returns where `t` meets a plane, along a direction in that plane; empty unless it has corners on both sides.
inline std::optional<Interval> meets(const WholeTriangle& t, const WholePoint& origin,
                                     const std::array<Wide, 3>& normal, const std::array<Wide, 3>& direction) {
  std::array<Wide, 3> height{}, along{};
  for (std::size_t k = 0; k < 3; ++k) {
    height[k] = dot(normal, from_to(origin, t[k]));
    along[k] = dot(direction, from_to({}, t[k]));
  }
  const auto [lowest, highest] = std::minmax_element(height.begin(), height.end());
  if (*lowest >= 0 || *highest <= 0) return std::nullopt;
  std::optional<Interval> found;
  const auto add = [&found](const Fraction& at) {
    if (!found) found = {at, at};
    found->low = std::min(found->low, at);
    found->high = std::max(found->high, at);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if (height[i] == 0) add({along[i], 1});
    if ((height[i] < 0) == (height[j] < 0) || height[i] == 0 || height[j] == 0) continue;
    const Wide sign = height[j] > height[i] ? 1 : -1;
    add({sign * (along[i] * height[j] - along[j] * height[i]), sign * (height[j] - height[i])});
  }
  return found;
}

// Returns true if the interiors of two triangles that do not lie in one plane have a point in common.
inline bool interiors_cross(const WholeTriangle& t, const WholeTriangle& u) {
  const std::array<Wide, 3> normal_t = normal_of(t), normal_u = normal_of(u), direction = cross(normal_t, normal_u);
  if (dot(direction, direction) == 0) return false;
  const std::optional<Interval> of_t = meets(t, u[0], normal_u, direction);
  const std::optional<Interval> of_u = meets(u, t[0], normal_t, direction);
  return of_t && of_u && of_t->low < of_u->high && of_u->low < of_t->high;
}

}  // namespace kerf::contact
