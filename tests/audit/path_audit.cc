#include "tests/audit/path_audit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "tests/audit/box_grid.h"
#include "tests/audit/curve_samples.h"
#include "tests/audit/exact_geometry.h"

namespace kerf::audit {
namespace {

using Box = Eigen::AlignedBox2d;
using Eigen::Vector2d;
using Range = std::pair<double, double>;  // interval of a parameter; empty if first > second

// Lattice units: largest distance of a lip from its place before the cut, because each split rounds by a unit or two.
constexpr double kRounding = 64.0;
// Lattice units: longest gap in the cover of a segment that counts as rounding of the intervals' ends.
constexpr double kNoGap = 128.0;

struct Segment {
  Vector2d a, b;         // lattice units
  bool is_dust = false;  // part of a stroke that is no larger than the snap distance
  [[nodiscard]] Box box(double margin) const {
    Box box(a.cwiseMin(b), a.cwiseMax(b));
    box.min().array() -= margin;
    box.max().array() += margin;
    return box;
  }
};

double cross(const Vector2d& u, const Vector2d& v) {
  return u.x() * v.y() - u.y() * v.x();
}

Range nothing() {
  return {1.0, 0.0};
}

void extend(Range& range, const Range& other) {
  if (other.first > other.second) return;
  range = range.first > range.second ? other
                                     : Range{std::min(range.first, other.first), std::max(range.second, other.second)};
}

// Returns the t in [0, 1] with |start + t step - centre| <= radius.
Range inside_disc(const Vector2d& start, const Vector2d& step, const Vector2d& centre, double radius) {
  const double a = step.squaredNorm();
  const double middle = (centre - start).dot(step) / a;
  const double off = (start + middle * step - centre).norm();
  if (off > radius) return nothing();
  const double half = std::sqrt((radius - off) * (radius + off) / a);
  const Range range{std::max(0.0, middle - half), std::min(1.0, middle + half)};
  return range.first <= range.second ? range : nothing();
}

// Returns the t in `range` with low <= f0 + t df <= high.
Range between(Range range, double f0, double df, double low, double high) {
  if (df == 0.0) return f0 >= low && f0 <= high ? range : nothing();
  double enter = (low - f0) / df;
  double leave = (high - f0) / df;
  if (enter > leave) std::swap(enter, leave);
  return {std::max(range.first, enter), std::min(range.second, leave)};
}

// Returns the part of `path` within `radius` of `other`. It is one interval, because the points within `radius` form a
// convex set.
Range near(const Segment& path, const Segment& other, double radius) {
  const Vector2d step = path.b - path.a;
  Range range = inside_disc(path.a, step, other.a, radius);
  extend(range, inside_disc(path.a, step, other.b, radius));
  const Vector2d along = other.b - other.a;
  const double length = along.norm();
  if (length > 0.0) {
    const Vector2d unit = along / length;
    const Vector2d from = path.a - other.a;
    const Range strip = between({0.0, 1.0}, from.dot(unit), step.dot(unit), 0.0, length);
    extend(range, between(strip, cross(unit, from), cross(unit, step), -radius, radius));
  }
  return range;
}

// Returns the part of `path` inside a counter-clockwise triangle whose edges are moved outwards by `margin`.
Range inside_triangle(const Segment& path, const std::array<Vector2d, 3>& corners, double margin) {
  Range range{0.0, 1.0};
  const Vector2d step = path.b - path.a;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector2d unit = (corners[(k + 1) % 3] - corners[k]).normalized();
    range = between(range, cross(unit, path.a - corners[k]), cross(unit, step), -margin,
                    std::numeric_limits<double>::infinity());
    if (range.first > range.second) return nothing();
  }
  return range;
}

// Returns the first part of `wanted` longer than `least` that `given` does not cover.
std::optional<Range> first_gap(std::vector<Range> wanted, std::vector<Range> given, double least) {
  std::sort(wanted.begin(), wanted.end());
  std::sort(given.begin(), given.end());
  for (const Range& want : wanted) {
    double at = want.first;
    for (const Range& have : given) {
      if (have.first > have.second || have.second < at) continue;
      if (have.first > at + least || at >= want.second) break;
      at = have.second;
    }
    if (at + least < want.second) return Range{at, want.second};
  }
  return std::nullopt;
}

// Holds the open edges of a sheet as segments, with a grid to find them.
class Locks {
 public:
  Locks(const mesh::TriangleMesh& mesh, mesh::LockBits which) : grid_({}) {
    const auto& triangles = mesh.data().triangles;
    const auto& points = mesh.data().points;
    std::vector<Box> boxes;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto other = static_cast<std::size_t>(triangles[t].neighbours[k]);
        if ((triangles[t].locks[k] & which) == 0 || other < t) continue;
        segments_.push_back({as_vector(points[static_cast<std::size_t>(triangles[t].points[(k + 1) % 3])].at),
                             as_vector(points[static_cast<std::size_t>(triangles[t].points[(k + 2) % 3])].at)});
        boxes.push_back(segments_.back().box(0.0));
      }
    }
    grid_ = BoxGrid(std::move(boxes));
  }

  [[nodiscard]] const std::vector<Segment>& segments() const { return segments_; }

  void cover(const Segment& path, double radius, std::vector<Range>& given) {
    grid_.for_touching(path.box(radius), [&](std::size_t i) { given.push_back(near(path, segments_[i], radius)); });
  }

 private:
  std::vector<Segment> segments_;
  BoxGrid grid_;
};

constexpr mesh::LockBits kOpen = mesh::kLockBorder | mesh::kLockCut;

class PathAudit {
 public:
  PathAudit(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after)
      : before_(before),
        after_(after),
        old_locks_(before, kOpen),
        new_locks_(after, kOpen),
        cuts_(after, mesh::kLockCut),
        grid_({}) {
    const auto& data = before.data();
    std::vector<Box> boxes;
    for (const mesh::TriangleRecord& r : data.triangles) {
      if (r.region < 0) continue;
      std::array<Vector2d, 3> corners;
      Box box;
      for (std::size_t k = 0; k < 3; ++k) {
        corners[k] = as_vector(data.points[static_cast<std::size_t>(r.points[k])].at);
        box.extend(corners[k]);
      }
      solid_.push_back(corners);
      boxes.push_back(box);
    }
    grid_ = BoxGrid(std::move(boxes));
    grazed_.resize(solid_.size());
    crossed_.resize(solid_.size());
  }

  Finding run(const cut::CutPlan& plan, const cut::CutReport& report) {
    if (Finding found = find_gap(plan, report)) return found;
    const auto least = std::count(crossed_.begin(), crossed_.end(), true);
    const auto most = std::count(grazed_.begin(), grazed_.end(), true);
    if (report.crossed_triangles < least || report.crossed_triangles > most) {
      return "crossed_triangles is " + std::to_string(report.crossed_triangles) + ", not between " +
             std::to_string(least) + " and " + std::to_string(most);
    }
    takes_material_ = plan.options.width_m.has_value();
    return find_stray_lip(segments_of(plan), radius_of(plan, report));
  }

  // Returns a stretch of the path inside the sheet that is not covered by lips or border. Marks the triangles that the
  // path crosses.
  Finding find_gap(const cut::CutPlan& plan, const cut::CutReport& report) {
    const double spacing = before_.data().lattice.spacing;
    const double radius = radius_of(plan, report);
    for (const Segment& segment : segments_of(plan)) {
      const double length = (segment.b - segment.a).norm();
      std::vector<Range> wanted, given;
      grid_.for_touching(segment.box(kRounding), [&](std::size_t i) {
        const Range range = inside_triangle(segment, solid_[i], 0.0);
        if (range.first <= range.second) wanted.push_back(range);
        const Range wide = inside_triangle(segment, solid_[i], kRounding);
        grazed_[i] = grazed_[i] || wide.first <= wide.second;
        const Range narrow = inside_triangle(segment, solid_[i], -kRounding);
        crossed_[i] = crossed_[i] || narrow.first < narrow.second;
      });
      new_locks_.cover(segment, radius, given);
      const auto gap = first_gap(std::move(wanted), std::move(given), kNoGap / length);
      if (!gap || (segment.is_dust && report.merged_segments > 0)) continue;
      if (plan.options.width_m && lies_in_void(segment, *gap, radius)) continue;  // removed between strips
      std::ostringstream text;
      const Vector2d at = segment.a + 0.5 * (gap->first + gap->second) * (segment.b - segment.a);
      text << "no lip within " << radius * spacing << " m of the path at lattice point (" << std::fixed << at.x()
           << ", " << at.y() << "), for " << (gap->second - gap->first) * length * spacing << " m";
      return text.str();
    }
    return std::nullopt;
  }

  Finding find_far_point(const std::vector<Vector2d>& points, double radius) {
    for (const Vector2d& point : points) {
      const Vector2d to_border(kRounding, kRounding);
      const Segment stub{point - to_border, point + to_border};
      bool inside = false;
      grid_.for_touching(stub.box(0.0), [&](std::size_t i) {
        const Range range = inside_triangle(stub, solid_[i], 0.0);
        inside = inside || (range.first <= 0.25 && range.second >= 0.75);
      });
      if (!inside) continue;
      std::vector<Range> given;
      new_locks_.cover(stub, radius + 2.0 * kRounding, given);
      if (!given.empty() && std::any_of(given.begin(), given.end(), [](const Range& r) { return r.first <= r.second; }))
        continue;
      std::ostringstream text;
      text << std::fixed << "the curve at lattice point (" << point.transpose() << ") is farther from every lip than "
           << radius << " units";
      return text.str();
    }
    return std::nullopt;
  }

 private:
  [[nodiscard]] double radius_of(const cut::CutPlan& plan, const cut::CutReport& report) const {
    return (report.deviation_m - plan.curve_deviation_m) / before_.data().lattice.spacing;
  }

  // Returns true if no material, farther than `radius` from its border, is left at `range` of the segment.
  [[nodiscard]] bool lies_in_void(const Segment& segment, const Range& range, double radius) const {
    constexpr int kSamples = 16;
    for (const mesh::TriangleRecord& r : after_.data().triangles) {
      if (r.region < 0) continue;
      std::array<Vector2d, 3> corners;
      for (std::size_t k = 0; k < 3; ++k) {
        corners[k] = as_vector(after_.data().points[static_cast<std::size_t>(r.points[k])].at);
      }
      for (int i = 0; i <= kSamples; ++i) {
        const double t = range.first + (range.second - range.first) * i / kSamples;
        const Vector2d at = segment.a + t * (segment.b - segment.a);
        const Segment stub{at, at + (segment.b - segment.a)};
        if (inside_triangle(stub, corners, -radius).first == 0.0) return false;
      }
    }
    return true;
  }

  std::vector<Segment> segments_of(const cut::CutPlan& plan) {
    const mesh::Lattice& lattice = before_.data().lattice;
    std::vector<Segment> path;
    const double dust = largest_snap(before_, plan);
    for (const cut::Stroke& stroke : plan.strokes) {
      Box box;
      for (const Vector2d& point : stroke.points) box.extend(point);
      const bool is_dust = box.diagonal().norm() <= dust;
      for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
        const Segment segment{(stroke.points[i] - lattice.origin) / lattice.spacing,
                              (stroke.points[i + 1] - lattice.origin) / lattice.spacing, is_dust};
        if (segment.a != segment.b) path.push_back(segment);
      }
    }
    return path;
  }

  Finding find_stray_lip(const std::vector<Segment>& path, double radius) {
    std::vector<Box> boxes;
    boxes.reserve(path.size());
    for (const Segment& segment : path) boxes.push_back(segment.box(0.0));
    BoxGrid path_grid(std::move(boxes));
    for (const Segment& lip : cuts_.segments()) {
      std::vector<Range> given;
      path_grid.for_touching(lip.box(radius), [&](std::size_t i) { given.push_back(near(lip, path[i], radius)); });
      old_locks_.cover(lip, kRounding, given);
      if (first_gap({{0.0, 1.0}}, std::move(given), kNoGap / (lip.b - lip.a).norm())) {
        std::ostringstream text;
        text << std::fixed << "a lip from (" << lip.a.transpose() << ") to (" << lip.b.transpose()
             << ") is neither old nor on the path";
        return text.str();
      }
    }
    for (const Segment& lip : old_locks_.segments()) {
      if (takes_material_) break;  // lips inside the strip are removed with it
      std::vector<Range> given;
      new_locks_.cover(lip, kRounding, given);
      if (first_gap({{0.0, 1.0}}, std::move(given), kNoGap / (lip.b - lip.a).norm())) return "an old lip is gone";
    }
    return std::nullopt;
  }

  const mesh::TriangleMesh& before_;
  const mesh::TriangleMesh& after_;
  Locks old_locks_, new_locks_, cuts_;
  std::vector<std::array<Vector2d, 3>> solid_;
  BoxGrid grid_;
  std::vector<bool> grazed_, crossed_;  // of solid_: touched by the path, and crossed by it
  bool takes_material_ = false;
};

}  // namespace

Finding find_path_flaw(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after, const cut::CutPlan& plan,
                       const cut::CutReport& report) {
  return PathAudit(before, after).run(plan, report);
}

Finding find_uncovered_path(const mesh::TriangleMesh& mesh, const cut::CutPlan& plan, const cut::CutReport& report) {
  return PathAudit(mesh, mesh).find_gap(plan, report);
}

Finding find_curve_flaw(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after, const cut::Curve& curve,
                        const cut::CutReport& report, int samples, double dust_m) {
  const mesh::Lattice& lattice = before.data().lattice;
  std::vector<Vector2d> points;
  for (const std::vector<Vector2d>& line : sample_curve(curve, samples, report.merged_segments > 0 ? dust_m : 0.0)) {
    for (const Vector2d& point : line) points.emplace_back((point - lattice.origin) / lattice.spacing);
  }
  return PathAudit(before, after).find_far_point(points, report.deviation_m / lattice.spacing);
}

double largest_tolerance(const mesh::TriangleMesh& mesh, const cut::CutPlan& plan) {
  const mesh::EdgeLengths& lengths = mesh.data().lengths;
  int exponent = 0;
  if (!lengths.exponents.empty()) exponent = *std::max_element(lengths.exponents.begin(), lengths.exponents.end());
  return plan.options.tolerance_m.value_or(plan.options.tolerance * std::ldexp(lengths.mean, exponent));
}

double largest_snap(const mesh::TriangleMesh& mesh, const cut::CutPlan& plan) {
  const double mean = plan.options.tolerance_m.value_or(plan.options.tolerance * plan.edge_length_m);
  return plan.snap_m * largest_tolerance(mesh, plan) / mean;
}

}  // namespace kerf::audit
