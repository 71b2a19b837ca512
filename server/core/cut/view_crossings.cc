#include "server/core/cut/view_crossings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "server/base/check.h"
#include "server/core/mesh/lattice_geometry.h"

namespace kerf::cut {

using Eigen::Vector2d;
using mesh::Int128;
using mesh::LatticePoint;
using mesh::next_corner;
using mesh::previous_corner;
using mesh::TriangleId;
using mesh::VertexId;

namespace {

constexpr double kFarthestPx = 1 << 30;  // px; farthest that a vertex may be from the picture's corner
constexpr int kGridSide = 64;
constexpr std::int64_t kMaxPairs = 50'000'000;  // most pairs of a triangle and a segment to examine

int sign(Int128 value) {
  return value > 0 ? 1 : (value < 0 ? -1 : 0);
}
int sign_of(std::int64_t value) {
  return value > 0 ? 1 : (value < 0 ? -1 : 0);
}

// Sides with respect to the curve shifted by (e, e^2), where e > 0 is infinitesimal. A side is 0 only if the ends of
// its segment or edge coincide.

// Returns the side of the segment pq, shifted, that the point a is on.
int side_of_segment(const LatticePoint& p, const LatticePoint& q, const LatticePoint& a) {
  const int exact = sign(mesh::doubled_area(p, q, a));
  if (exact != 0) return exact;
  const int first = sign_of(q.y - p.y);
  return first != 0 ? first : -sign_of(q.x - p.x);
}

// Returns the side of the edge ab that the point p, shifted, is on.
int side_of_edge(const LatticePoint& a, const LatticePoint& b, const LatticePoint& p) {
  const int exact = sign(mesh::doubled_area(a, b, p));
  if (exact != 0) return exact;
  const int first = -sign_of(b.y - a.y);
  return first != 0 ? first : sign_of(b.x - a.x);
}

// Returns |first| / (|first| + |second|), in [0, 1]; 0.5 if both are 0.
double share_of(Int128 first, Int128 second) {
  const double a = std::abs(static_cast<double>(first));
  const double b = std::abs(static_cast<double>(second));
  return a + b > 0.0 ? a / (a + b) : 0.5;
}

struct ScreenSegment {
  LatticePoint from, to;
  std::int32_t first_point = 0;  // number of `from` among the points of all strokes; `to` is the next
};

std::vector<ScreenSegment> segments_of(const std::vector<Stroke>& strokes) {
  std::vector<ScreenSegment> segments;
  std::int32_t point = 0;
  for (const Stroke& stroke : strokes) {
    LatticePoint from = screen_point(stroke.points.front());
    for (std::size_t i = 1; i < stroke.points.size(); ++i) {
      const LatticePoint to = screen_point(stroke.points[i]);
      if (to == from) continue;
      segments.push_back({from, to, point++});
      from = to;
    }
    ++point;
  }
  return segments;
}

// A grid of cells over the curve's part of the picture, each with the segments that may pass through it.
class SegmentGrid {
 public:
  explicit SegmentGrid(const std::vector<ScreenSegment>& segments) : last_query_(segments.size(), -1) {
    low_ = high_ = difference({}, segments.front().from);
    for (const ScreenSegment& s : segments) {
      for (const LatticePoint& p : {s.from, s.to}) {
        low_ = low_.cwiseMin(difference({}, p));
        high_ = high_.cwiseMax(difference({}, p));
      }
    }
    cell_ = ((high_ - low_) / kGridSide).cwiseMax(1.0);
    cells_.resize(static_cast<std::size_t>(kGridSide) * kGridSide);
    for (std::size_t i = 0; i < segments.size(); ++i) {
      for_cells(difference({}, segments[i].from), difference({}, segments[i].to),
                [&](std::vector<std::size_t>& cell) { cell.push_back(i); });
    }
  }

  // Calls visit(i) once for each segment i whose box may meet the box of three points.
  template <typename Visit>
  void visit_near(const std::array<LatticePoint, 3>& corners, const Visit& visit) {
    const Vector2d a = difference({}, corners[0]);
    const Vector2d b = difference({}, corners[1]);
    const Vector2d c = difference({}, corners[2]);
    const Vector2d low = a.cwiseMin(b).cwiseMin(c);
    const Vector2d high = a.cwiseMax(b).cwiseMax(c);
    if ((low.array() > high_.array()).any() || (high.array() < low_.array()).any()) return;
    ++query_;
    for_cells(low, high, [&](const std::vector<std::size_t>& cell) {
      for (const std::size_t i : cell) {
        if (last_query_[i] == query_) continue;
        last_query_[i] = query_;
        visit(i);
      }
    });
  }

 private:
  [[nodiscard]] int column(double value, int axis) const {
    const double cell = std::floor((value - low_[axis]) / cell_[axis]);
    return static_cast<int>(std::clamp(cell, 0.0, static_cast<double>(kGridSide - 1)));
  }

  template <typename Do>
  void for_cells(const Vector2d& a, const Vector2d& b, const Do& act) {
    const Vector2d low = a.cwiseMin(b);
    const Vector2d high = a.cwiseMax(b);
    for (int y = column(low.y(), 1); y <= column(high.y(), 1); ++y) {
      for (int x = column(low.x(), 0); x <= column(high.x(), 0); ++x) {
        act(cells_[static_cast<std::size_t>(y) * kGridSide + static_cast<std::size_t>(x)]);
      }
    }
  }

  Vector2d low_, high_, cell_;
  std::vector<std::vector<std::size_t>> cells_;
  std::vector<std::int64_t> last_query_;
  std::int64_t query_ = 0;
};

// One triangle as seen in the picture.
class Facet {
 public:
  Facet(const mesh::TriangleMesh& mesh, const Screen& screen, TriangleId triangle) : triangle_(triangle) {
    for (std::size_t k = 0; k < 3; ++k) {
      Corner& corner = corners_[k];
      corner.vertex = mesh.vertices(triangle)[k];
      corner.rest = mesh.rest_position(corner.vertex);
      corner.seen = screen.vertices[static_cast<std::size_t>(corner.vertex)];
      seen_ = seen_ && corner.seen.seen;
    }
    area_ = mesh::doubled_area(at(0), at(1), at(2));
  }

  // Returns true if all three vertices are seen and the triangle is not just a line.
  [[nodiscard]] bool is_seen() const { return seen_ && area_ != 0; }
  [[nodiscard]] std::array<LatticePoint, 3> picture() const { return {at(0), at(1), at(2)}; }

  // Finds the part of the segment in the triangle; returns false if there is none.
  bool clip(const ScreenSegment& segment, std::int32_t number, ViewInterval& interval) const {
    std::array<ViewNode, 5> nodes;
    std::size_t found = 0;
    if (contains(segment.from)) nodes[found++] = joint(segment.from, segment.first_point, 0.0);
    for (int k = 0; k < 3; ++k) {
      if (crosses(segment, k)) nodes[found++] = crossing(segment, k);
    }
    if (contains(segment.to)) nodes[found++] = joint(segment.to, segment.first_point + 1, 1.0);
    if (found == 0) return false;
    KERF_CHECK(found == 2, "a segment enters and leaves a triangle, or ends in it");
    const bool in_order = nodes[0].at <= nodes[1].at;
    interval = {triangle_, number, nodes[in_order ? 0 : 1], nodes[in_order ? 1 : 0]};
    return true;
  }

  // Bounds the derivative of the map from picture to material space. Let b_i be the barycentric coordinates in the
  // picture, which are linear there, and w_i the clip w of the corners. The image is r = sum_i r_i b_i / w_i / sum_j
  // b_j / w_j, so dr = sum_i (r_i - r) db_i / w_i / sum_j b_j / w_j.
  [[nodiscard]] ViewStretch stretch() const {
    ViewStretch stretch;
    double sum = 0.0;
    double least_inverse_w = corners_[0].seen.inverse_w;
    for (int k = 0; k < 3; ++k) {
      const Corner& a = corner(next_corner(k));
      const Corner& b = corner(previous_corner(k));
      stretch.longest_m = std::max(stretch.longest_m, (a.rest - b.rest).norm());
      sum += difference(a.seen.at, b.seen.at).norm() * corner(k).seen.inverse_w;
      least_inverse_w = std::min(least_inverse_w, corner(k).seen.inverse_w);
    }
    const double area = std::abs(static_cast<double>(area_));
    stretch.m_per_px = stretch.longest_m * sum / (area * least_inverse_w) * Screen::kUnitsPerPx;
    return stretch;
  }

 private:
  struct Corner {
    VertexId vertex = mesh::kNone;
    Vector2d rest{0.0, 0.0};  // m
    Screen::Vertex seen;
  };

  [[nodiscard]] const Corner& corner(int k) const { return corners_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] const LatticePoint& at(int k) const { return corner(k).seen.at; }

  // Returns the two ends of the edge opposite corner k, the lower vertex first. So both triangles at an edge compute
  // the same crossing.
  [[nodiscard]] std::array<int, 2> edge(int k) const {
    const int a = next_corner(k);
    const int b = previous_corner(k);
    if (corner(a).vertex < corner(b).vertex) return {a, b};
    return {b, a};
  }

  [[nodiscard]] bool contains(const LatticePoint& p) const {
    const int turn = sign(area_);
    for (int k = 0; k < 3; ++k) {
      const auto [a, b] = edge(k);
      if (side_of_edge(at(a), at(b), p) != (a == next_corner(k) ? turn : -turn)) return false;
    }
    return true;
  }

  [[nodiscard]] bool crosses(const ScreenSegment& s, int k) const {
    const auto [a, b] = edge(k);
    return side_of_segment(s.from, s.to, at(a)) != side_of_segment(s.from, s.to, at(b)) &&
           side_of_edge(at(a), at(b), s.from) != side_of_edge(at(a), at(b), s.to);
  }

  [[nodiscard]] ViewNode crossing(const ScreenSegment& s, int k) const {
    const auto [a, b] = edge(k);
    const Corner& low = corner(a);
    const Corner& high = corner(b);
    ViewNode node;
    node.kind = ViewNode::Kind::kEdge;
    node.low = low.vertex;
    node.high = high.vertex;
    node.at = share_of(mesh::doubled_area(at(a), at(b), s.from), mesh::doubled_area(at(a), at(b), s.to));
    const double share = share_of(mesh::doubled_area(s.from, s.to, at(a)), mesh::doubled_area(s.from, s.to, at(b)));
    node.inverse_w = (1.0 - share) * low.seen.inverse_w + share * high.seen.inverse_w;
    const double in_rest = share * high.seen.inverse_w / node.inverse_w;
    node.rest = (1.0 - in_rest) * low.rest + in_rest * high.rest;
    node.depth = (1.0 - in_rest) * low.seen.depth + in_rest * high.seen.depth;
    return node;
  }

  [[nodiscard]] ViewNode joint(const LatticePoint& p, std::int32_t number, double at_segment) const {
    ViewNode node;
    node.kind = ViewNode::Kind::kJoint;
    node.low = number;
    node.high = triangle_;
    node.at = at_segment;
    double sum = 0.0;
    std::array<double, 3> shares{};
    for (int k = 0; k < 3; ++k) {
      const Int128 part = mesh::doubled_area(at(next_corner(k)), at(previous_corner(k)), p);
      shares[static_cast<std::size_t>(k)] = std::abs(static_cast<double>(part));
      sum += shares[static_cast<std::size_t>(k)];
    }
    for (int k = 0; k < 3; ++k) node.inverse_w += shares[static_cast<std::size_t>(k)] / sum * corner(k).seen.inverse_w;
    for (int k = 0; k < 3; ++k) {
      const double in_rest = shares[static_cast<std::size_t>(k)] / sum * corner(k).seen.inverse_w / node.inverse_w;
      node.rest += in_rest * corner(k).rest;
      node.depth += in_rest * corner(k).seen.depth;
    }
    return node;
  }

  TriangleId triangle_;
  std::array<Corner, 3> corners_;
  bool seen_ = true;
  Int128 area_ = 0;
};

std::int64_t jitter(std::uint64_t number) {
  number *= 0xbf58476d1ce4e5b9ULL;
  number ^= number >> 31;
  number *= 0x94d049bb133111ebULL;
  return static_cast<std::int64_t>(number >> 40) % (2 * Screen::kJitter + 1) - Screen::kJitter;
}

}  // namespace

LatticePoint screen_point(const Vector2d& px) {
  return {std::llround(px.x() * Screen::kUnitsPerPx), std::llround(px.y() * Screen::kUnitsPerPx)};
}

Screen project(const linear::VertexField& positions, const View& view) {
  Screen screen;
  screen.vertices.resize(static_cast<std::size_t>(positions.cols()));
  for (Eigen::Index i = 0; i < positions.cols(); ++i) {
    Screen::Vertex& vertex = screen.vertices[static_cast<std::size_t>(i)];
    const Eigen::Vector4d camera = view.view * positions.col(i).homogeneous();
    const Eigen::Vector4d clip = view.projection * camera;
    vertex.depth = -camera.z();
    const double w = clip.w();
    if (!(vertex.depth > 0.0) || !(w > 0.0)) continue;
    const Vector2d px(0.5 * (1.0 + clip.x() / w) * view.width_px, 0.5 * (1.0 - clip.y() / w) * view.height_px);
    if (!(px.cwiseAbs().maxCoeff() < kFarthestPx)) continue;
    vertex.at = screen_point(px);
    vertex.at.x += jitter(2 * static_cast<std::uint64_t>(i) + 1);
    vertex.at.y += jitter(2 * static_cast<std::uint64_t>(i) + 2);
    vertex.inverse_w = 1.0 / w;
    vertex.seen = std::isfinite(vertex.inverse_w);
  }
  return screen;
}

Result<ViewCrossings> find_crossings(const mesh::TriangleMesh& mesh, const Screen& screen,
                                     const std::vector<Stroke>& strokes) {
  ViewCrossings crossings;
  const std::vector<ScreenSegment> segments = segments_of(strokes);
  if (segments.empty()) return crossings;
  SegmentGrid grid(segments);
  std::int64_t pairs = 0;
  for (TriangleId t = 0; t < mesh.num_triangle_slots() && pairs <= kMaxPairs; ++t) {
    if (!mesh.is_solid(t)) continue;
    const Facet facet(mesh, screen, t);
    if (!facet.is_seen()) {
      ++crossings.behind;
      continue;
    }
    const std::size_t before = crossings.intervals.size();
    grid.visit_near(facet.picture(), [&](std::size_t i) {
      ++pairs;
      ViewInterval interval;
      if (facet.clip(segments[i], static_cast<std::int32_t>(i), interval)) crossings.intervals.push_back(interval);
    });
    if (crossings.intervals.size() > before) {
      crossings.stretches.push_back(facet.stretch());
    }
  }
  if (pairs > kMaxPairs) {
    return resource_exhausted("VIEW_WORK_BUDGET",
                              "the curve meets too many triangles in the picture; draw a shorter one", "cut.curve");
  }
  std::sort(crossings.intervals.begin(), crossings.intervals.end(), [](const ViewInterval& a, const ViewInterval& b) {
    return std::tie(a.segment, a.begin.at, a.triangle) < std::tie(b.segment, b.begin.at, b.triangle);
  });
  return crossings;
}

}  // namespace kerf::cut
