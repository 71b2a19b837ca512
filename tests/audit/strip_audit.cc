#include "tests/audit/strip_audit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "server/base/random.h"
#include "tests/audit/box_grid.h"
#include "tests/audit/curve_samples.h"
#include "tests/audit/exact_geometry.h"
#include "tests/audit/path_audit.h"

namespace kerf::audit {
namespace {

using Box = Eigen::AlignedBox2d;
using Eigen::Vector2d;
using mesh::kNone;
using mesh::MeshData;
using mesh::TriangleRecord;

Vector2d position(const MeshData& data, mesh::PointId p) {
  return data.lattice.position(data.points[index(p)].at);
}

double distance_to_segment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  const double squared = along.squaredNorm();
  const double t = squared > 0.0 ? std::clamp((p - a).dot(along) / squared, 0.0, 1.0) : 0.0;
  return (p - a - t * along).norm();
}

double distance_to(const std::vector<std::vector<Vector2d>>& lines, const Vector2d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const std::vector<Vector2d>& line : lines) {
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      least = std::min(least, distance_to_segment(p, line[i], line[i + 1]));
    }
  }
  return least;
}

// Returns the winding number of closed lines around p, as the sum of the angles of their sides seen from p.
double winding(const std::vector<std::vector<Vector2d>>& lines, const Vector2d& p) {
  double angle = 0.0;
  for (const std::vector<Vector2d>& line : lines) {
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const Vector2d a = line[i] - p;
      const Vector2d b = line[i + 1] - p;
      angle += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
    }
  }
  return angle / (2.0 * 3.14159265358979323846);
}

// Finds whether a place has material.
class Solid {
 public:
  explicit Solid(const mesh::TriangleMesh& mesh) : data_(mesh.data()), grid_({}) {
    std::vector<Box> boxes;
    for (std::size_t t = 0; t < data_.triangles.size(); ++t) {
      const TriangleRecord& r = data_.triangles[t];
      if (r.region < 0) continue;
      Box box;
      for (const mesh::PointId p : r.points) box.extend(position(data_, p));
      boxes.push_back(box);
      slots_.push_back(t);
    }
    grid_ = BoxGrid(std::move(boxes));
  }

  // True if `p` lies in the box of a solid triangle and more than `margin` (m) inside its sides. Below 0, it may lie
  // outside them by -margin.
  bool holds(const Vector2d& p, double margin) {
    bool found = false;
    grid_.for_touching(Box(p, p), [&](std::size_t i) {
      const TriangleRecord& r = data_.triangles[slots_[i]];
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector2d a = position(data_, r.points[k]);
        const Vector2d along = (position(data_, r.points[(k + 1) % 3]) - a).normalized();
        least = std::min(least, along.x() * (p - a).y() - along.y() * (p - a).x());
      }
      found = found || least > margin;
    });
    return found;
  }

 private:
  const MeshData& data_;
  std::vector<std::size_t> slots_;
  BoxGrid grid_;
};

// Returns the area of the material in the rest shape, m^2; of a curved one on its surface.
double area(const MeshData& data) {
  std::vector<Wide> doubled(data.surface ? data.surface->facets.size() : 1, 0);  // by facet
  for (const TriangleRecord& r : data.triangles) {
    if (r.region < 0) continue;
    const auto& a = data.points[index(r.points[0])].at;
    const auto& b = data.points[index(r.points[1])].at;
    const auto& c = data.points[index(r.points[2])].at;
    doubled[data.surface ? index(r.region) : 0] += Wide{b.x - a.x} * (c.y - a.y) - Wide{b.y - a.y} * (c.x - a.x);
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < doubled.size(); ++i) {
    const double in_plane = 0.5 * static_cast<double>(doubled[i]) * data.lattice.spacing * data.lattice.spacing;
    sum += data.surface ? data.surface->facets[i].area_ratio() * in_plane : in_plane;
  }
  return sum;
}

std::vector<std::vector<Vector2d>> lines_of(const std::vector<cut::Stroke>& strokes) {
  std::vector<std::vector<Vector2d>> lines;
  for (const cut::Stroke& stroke : strokes) lines.push_back(stroke.points);
  return lines;
}

Finding find_wrong_counts(const MeshData& before, const MeshData& after, const cut::CutOutcome& outcome) {
  std::vector<mesh::VertexId> gone;
  for (std::size_t v = 0; v < before.vertices.size(); ++v) {
    if (before.vertices[v].triangle != kNone && after.vertices[v].triangle == kNone) {
      gone.push_back(static_cast<mesh::VertexId>(v));
    }
    if (before.vertices[v].triangle == kNone && after.vertices[v].triangle != kNone) {
      return "vertex " + std::to_string(v) + " has come back";
    }
  }
  for (std::size_t v = before.vertices.size(); v < after.vertices.size(); ++v) {
    if (after.vertices[v].triangle == kNone) return "vertex " + std::to_string(v) + " was made and removed at once";
  }
  if (gone != outcome.edit.removed_vertices) return "removed_vertices are not those without a triangle";
  const cut::CutReport& report = outcome.report;
  if (report.removed_vertices != static_cast<std::int32_t>(gone.size())) return "removed_vertices is wrong";
  if (report.removed_pieces != static_cast<std::int32_t>(outcome.edit.removed_pieces.size())) {
    return "removed_pieces is wrong";
  }
  const double total = area(before);
  if (std::abs(total - area(after) - report.removed_area_m2) > 1e-12 * total) return "removed_area_m2 is wrong";
  return std::nullopt;
}

}  // namespace

Finding find_strip_flaw(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after, const cut::CutPlan& plan,
                        const cut::CutOutcome& outcome) {
  if (Finding found = find_wrong_counts(before.data(), after.data(), outcome)) return found;
  // Checks some rewritten triangles: those left must be outside the outline, those removed inside.
  constexpr std::size_t kLookedAt = 100;
  const auto& rewritten = outcome.edit.rewritten_triangles;
  const std::size_t stride = rewritten.size() / kLookedAt + 1;
  const auto outline = lines_of(plan.outline);
  const double margin = outcome.report.deviation_m - plan.curve_deviation_m;  // distance from outline to border
  if (margin > *plan.options.width_m / 8.0) return "the sides of the strip have moved by more than an eighth of it";
  Solid is(after);
  for (std::size_t i = 0; i < rewritten.size(); i += stride) {
    const mesh::TriangleId t = rewritten[i];
    const bool existed = index(t) < before.data().triangles.size();
    const bool was_solid = existed && before.data().triangles[index(t)].region >= 0;
    const TriangleRecord& r = after.data().triangles[index(t)];
    if (r.region < 0 && !was_solid) continue;
    const MeshData& data = r.region >= 0 ? after.data() : before.data();
    const TriangleRecord& shape = data.triangles[index(t)];
    const Vector2d centre =
        (position(data, shape.points[0]) + position(data, shape.points[1]) + position(data, shape.points[2])) / 3.0;
    if (distance_to(outline, centre) <= margin) continue;
    const bool inside = winding(outline, centre) > 0.5;
    if (inside && is.holds(centre, 0.0)) return "slot " + std::to_string(t) + " is left inside the strip";
    if (!inside && !is.holds(centre, -margin)) return "material of slot " + std::to_string(t) + " is gone";
  }
  // No piece may be left inside the outline, even one that the cut did not touch.
  std::vector<bool> seen(index(after.data().num_pieces), false);
  for (const TriangleRecord& r : after.data().triangles) {
    if (r.region < 0 || seen[index(r.piece)]) continue;
    seen[index(r.piece)] = true;
    const MeshData& data = after.data();
    const Vector2d centre =
        (position(data, r.points[0]) + position(data, r.points[1]) + position(data, r.points[2])) / 3.0;
    if (distance_to(outline, centre) > margin && winding(outline, centre) > 0.5) {
      return "piece " + std::to_string(r.piece) + " is left inside the strip";
    }
  }
  return std::nullopt;
}

Finding find_strewn_flaw(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after, const cut::Curve& curve,
                         const cut::CutPlan& plan, const cut::CutOutcome& outcome, std::uint64_t seed, int samples) {
  if (const auto* path = std::get_if<cut::Path>(&curve)) {
    for (const cut::Subpath& subpath : path->subpaths) {
      for (const cut::Segment& segment : subpath.segments) {
        if (std::holds_alternative<cut::ArcTo>(segment)) return std::nullopt;
      }
    }
  }
  // With so many samples the curve deviates from its chords by far less than the margin.
  constexpr int kSamplesOfCurve = 1000;
  const auto lines = sample_curve(curve, kSamplesOfCurve);
  const double radius = 0.5 * *plan.options.width_m;
  const double rounding = 1e-6 * before.bounding_box().sizes().maxCoeff();
  const double margin = outcome.report.deviation_m + rounding;
  Solid was(before), is(after);
  SeededRandom random(seed);
  const Box& box = before.bounding_box();
  for (int i = 0; i < samples; ++i) {
    Vector2d p(random.uniform(box.min().x(), box.max().x()), random.uniform(box.min().y(), box.max().y()));
    if (i % 2 == 0) {
      const auto& line = lines[static_cast<std::size_t>(random.uniform(0.0, 1.0) * static_cast<double>(lines.size()))];
      const auto& at = line[static_cast<std::size_t>(random.uniform(0.0, 1.0) * static_cast<double>(line.size()))];
      p = at + 2.0 * radius * Vector2d(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    }
    if (!was.holds(p, rounding)) continue;
    const double distance = distance_to(lines, p);
    const auto say = [&](const char* what) {
      return std::string(what) + " " + std::to_string(distance) + " m from the curve, at (" + std::to_string(p.x()) +
             ", " + std::to_string(p.y()) + "); half the width is " + std::to_string(radius);
    };
    if (distance < radius - margin && is.holds(p, 0.0)) return say("material is left");
    if (distance > radius + margin && !is.holds(p, -rounding)) return say("material is gone");
  }
  return std::nullopt;
}

}  // namespace kerf::audit
