#include "server/core/scene/outline_source.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <string>
#include <utility>
#include <variant>

#include "server/core/cut/fit.h"
#include "server/core/mesh/build/outline_mesh.h"
#include "server/core/scene/field_checks.h"

namespace kerf::scene {
namespace {

using Eigen::Vector2d;

constexpr double kMinEdgeLength = 1.0e-9;  // m
constexpr double kMinGrowth = 0.01;        // -
constexpr double kMaxGrowth = 10.0;        // -
constexpr double kMinOutlineAngle = 5.0;   // degrees

// Largest distance of curves from their chords, as a fraction (kFlatness) of the shortest edge length wanted. For a
// small curve it is that fraction of kShareOfCurve times its size, if that is less. But it is at least kLeastFlatness
// times the border's larger side.  -
constexpr double kFlatness = 2.0e-5;
constexpr double kLeastFlatness = 1.0e-9;
constexpr double kShareOfCurve = 0.1;
// The same for curves along which an edge length is wanted, as a fraction of that length.  -
constexpr double kFlatnessOfSizes = 0.05;

Status check_sizing(const OutlineSizing& sizing, const std::string& field) {
  if (const auto* point = std::get_if<Vector2d>(&sizing.place)) {
    KERF_TRY(check_vector(*point, kMaxMaterialCoordinate, field + ".point"));
  } else {
    KERF_TRY(check_curve(std::get<cut::Curve>(sizing.place), field + ".curve"));
  }
  KERF_TRY(check_number(sizing.edge_length, kMinEdgeLength, kMaxMaterialCoordinate, field + ".edge_length_m"));
  return check_number(sizing.growth, kMinGrowth, kMaxGrowth, field + ".growth");
}

// Returns the ends of the pieces of a curve, in order. They must become vertices.
std::vector<Vector2d> joints_of(const cut::CubicBezier& bezier) {
  std::vector<Vector2d> joints;
  for (std::size_t i = 0; i < bezier.points.size(); i += 3) joints.push_back(bezier.points[i]);
  return joints;
}
std::vector<Vector2d> joints_of(const cut::Polyline& polyline) {
  return polyline.points;
}
std::vector<Vector2d> joints_of(const cut::Circle& /*circle*/) {
  return {};
}
std::vector<Vector2d> joints_of(const cut::Ellipse& /*ellipse*/) {
  return {};
}
std::vector<Vector2d> joints_of(const cut::Path& path) {
  std::vector<Vector2d> joints;
  for (const cut::Subpath& subpath : path.subpaths) {
    joints.push_back(subpath.start);
    for (const cut::Segment& segment : subpath.segments) {
      joints.push_back(std::visit([](const auto& each) { return each.end; }, segment));
    }
  }
  return joints;
}

// Splits a curve of several lines into curves of one line each.
std::vector<cut::Curve> lines_of(const cut::Curve& curve) {
  const auto* path = std::get_if<cut::Path>(&curve);
  if (path == nullptr) return {curve};
  std::vector<cut::Curve> lines;
  for (const cut::Subpath& subpath : path->subpaths) lines.emplace_back(cut::Path{{subpath}});
  return lines;
}

std::string place(const Vector2d& at) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "(%.6g, %.6g) m", at.x(), at.y());
  return text.data();
}

class OutlineFlattening {
 public:
  explicit OutlineFlattening(const OutlineSource& source) : source_(source) {
    const cut::Box box = cut::extent(source.boundary);
    side_ = (box.high - box.low).maxCoeff();
    config_.edge_length = source.edge_length;
    config_.min_angle_deg = source.min_angle_deg;
    shortest_ = source.edge_length > 0.0 ? source.edge_length : side_;
    for (const OutlineSizing& sizing : source.sizes) shortest_ = std::min(shortest_, sizing.edge_length);
  }

  Result<mesh::OutlineConfig> run() {
    KERF_TRY(add_contours(source_.boundary, "outline.boundary"));
    if (config_.contours.empty()) {
      return invalid_argument("OUTLINE_BORDER", "the border must have a closed line", "outline.boundary");
    }
    config_.num_border_contours = config_.contours.size();
    for (std::size_t i = 0; i < source_.holes.size(); ++i) {
      KERF_TRY(add_contours(source_.holes[i], indexed("outline.holes", i)));
    }
    for (std::size_t i = 0; i < source_.sizes.size(); ++i) {
      KERF_TRY(add_size(source_.sizes[i], indexed("outline.sizes", i)));
    }
    return std::move(config_);
  }

 private:
  Status count(const cut::FlatCurve& flat, const std::string& field) {
    for (const cut::Stroke& stroke : flat.strokes) num_chords_ += stroke.points.size() - 1;
    if (num_chords_ <= kMaxOutlineChords) return Nothing{};
    return resource_exhausted("OUTLINE_CURVES",
                              "the curves of the outline need more than " + std::to_string(kMaxOutlineChords) +
                                  " chords; use fewer curves or longer edges",
                              field);
  }

  Status add_contours(const cut::Curve& curve, const std::string& field) {
    for (const cut::Curve& line : lines_of(curve)) {
      const cut::Box box = cut::extent(line);
      const double size = std::min(shortest_, kShareOfCurve * (box.high - box.low).maxCoeff());
      const double tolerance = std::max({kFlatness * size, kLeastFlatness * side_, kLeastFlatness * kMinEdgeLength});
      const cut::FlatCurve flat = cut::flatten(line, tolerance);
      KERF_TRY(count(flat, field));
      const std::vector<Vector2d> joints = std::visit([](const auto& each) { return joints_of(each); }, line);
      for (const cut::Stroke& stroke : flat.strokes) {
        KERF_TRY(add_contour(stroke, joints, field));
      }
    }
    return Nothing{};
  }

  Status add_contour(const cut::Stroke& stroke, const std::vector<Vector2d>& joints, const std::string& field) {
    const auto is_outside = [](const Vector2d& p) { return p.cwiseAbs().maxCoeff() > kMaxMaterialCoordinate; };
    if (std::any_of(stroke.points.begin(), stroke.points.end(), is_outside)) {
      return invalid_argument("OUTLINE_OUT_OF_RANGE", field + " reaches farther than 1e4 m from the origin", field);
    }
    if (stroke.points.front() != stroke.points.back()) {
      return invalid_argument("OUTLINE_OPEN",
                              field + " has a line that begins at " + place(stroke.points.front()) + " and ends at " +
                                  place(stroke.points.back()) +
                                  "; lead it back to its start, or leave it out (of a drawing, with `only`)",
                              field);
    }
    mesh::OutlineContour contour;
    contour.field = field;
    contour.points.assign(stroke.points.begin(), stroke.points.end() - 1);
    auto at = contour.points.begin();
    for (const Vector2d& joint : joints) {
      const auto found = std::find(at, contour.points.end(), joint);
      if (found == contour.points.end()) continue;  // the last joint, which is the first point
      const auto index = static_cast<std::size_t>(found - contour.points.begin());
      if (contour.corners.empty() || contour.corners.back() != index) contour.corners.push_back(index);
      at = found;
    }
    config_.contours.push_back(std::move(contour));
    return Nothing{};
  }

  Status add_size(const OutlineSizing& sizing, const std::string& field) {
    mesh::OutlineSize size;
    size.length = sizing.edge_length;
    size.growth = sizing.growth;
    size.field = field + ".edge_length_m";
    if (const auto* point = std::get_if<Vector2d>(&sizing.place)) {
      size.points = {*point};
      config_.sizes.push_back(std::move(size));
      return Nothing{};
    }
    const auto& curve = std::get<cut::Curve>(sizing.place);
    const double tolerance = kFlatnessOfSizes * std::max(sizing.edge_length, kLeastFlatness * side_);
    const cut::FlatCurve flat = cut::flatten(curve, tolerance);
    KERF_TRY(count(flat, field + ".curve"));
    for (const cut::Stroke& stroke : flat.strokes) {
      size.points = stroke.points;
      config_.sizes.push_back(size);
    }
    return Nothing{};
  }

  const OutlineSource& source_;
  mesh::OutlineConfig config_;
  double side_ = 0.0;      // m, larger side of the border
  double shortest_ = 0.0;  // m, shortest edge length requested
  std::size_t num_chords_ = 0;
};

}  // namespace

Status validate(const OutlineSource& outline) {
  KERF_TRY(check_curve(outline.boundary, "outline.boundary"));
  KERF_TRY(check_count(outline.holes.size(), kMaxOutlineHoles, "curves", "outline.holes"));
  for (std::size_t i = 0; i < outline.holes.size(); ++i) {
    KERF_TRY(check_curve(outline.holes[i], indexed("outline.holes", i)));
  }
  if (outline.edge_length != 0.0) {
    KERF_TRY(check_number(outline.edge_length, kMinEdgeLength, kMaxMaterialCoordinate, "outline.edge_length_m"));
  }
  KERF_TRY(check_count(outline.sizes.size(), kMaxOutlineSizes, "sizes", "outline.sizes"));
  for (std::size_t i = 0; i < outline.sizes.size(); ++i) {
    KERF_TRY(check_sizing(outline.sizes[i], indexed("outline.sizes", i)));
  }
  return check_number(outline.min_angle_deg, kMinOutlineAngle, mesh::kMaxOutlineAngle, "outline.min_angle_deg");
}

Result<mesh::TriangleMesh> mesh_outline(const OutlineSource& outline, std::int32_t max_vertices) {
  KERF_TRY_ASSIGN(mesh::OutlineConfig config, OutlineFlattening(outline).run());
  config.max_vertices = max_vertices;
  Result<mesh::TriangleMesh> built = mesh::mesh_outline(config);
  if (built.ok()) return built;
  Error error = built.error();
  if (error.field == "edge_length") error.field = "outline.edge_length_m";
  return error;
}

}  // namespace kerf::scene
