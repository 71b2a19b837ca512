#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "server/base/check.h"
#include "server/core/cut/bent_edges.h"
#include "server/core/cut/cut.h"
#include "server/core/cut/dash.h"
#include "server/core/cut/element_path.h"
#include "server/core/cut/fit.h"
#include "server/core/cut/join.h"
#include "server/core/cut/outline.h"
#include "server/core/cut/path_scale.h"
#include "server/core/cut/simplify.h"
#include "server/core/cut/stroke.h"

namespace kerf::cut {
namespace {

constexpr double kMaxPathPoints = 1.0e6;  // most points of a path after spacing; more would exceed any limit on
                                          // triangles

// The curve is clipped at most this fraction of Lattice::room() outside the sheet, plus the snap distance. The domain
// is large enough for both: the snap distance is at most a tenth of the edge length, which is at most sqrt(2) times the
// room. -
constexpr double kClipRoom = 0.25;

// Fraction of the tolerance for flattening the curve of a cut with a width; the rest is for its outline. -
constexpr double kWidthFlattening = 0.5;

// Factor on the flattening tolerance for Method::kElement, which chooses the ends of its chords among the points of a
// finer polyline. -
constexpr double kElementFlattening = 0.25;

Status check_range(double value, double low, double high, const std::string& field) {
  if (value >= low && value <= high) return Nothing{};  // false for NaN
  return invalid_argument(
      "OPTION_OUT_OF_RANGE",
      field + " is " + std::to_string(value) + "; allowed is " + std::to_string(low) + " to " + std::to_string(high),
      field);
}

Status place(const mesh::TriangleMesh& mesh, const Fit& fit, Curve& curve) {
  if (fit.box) return fit_into(*fit.box, curve);
  const Eigen::AlignedBox2d& bounds = mesh.bounding_box();
  const Eigen::Vector2d margin = kFitMargin * bounds.sizes();
  return fit_into({bounds.min() + margin, bounds.max() - margin}, curve);
}

Status check_options(const CutOptions& options) {
  KERF_TRY(check_ranges(options, 0.0, check_range));
  if (options.method == Method::kElement && options.tip_edge_length_m) {
    return invalid_argument("OPTIONS_CONFLICT",
                            "cut.tip_edge_length_m needs method neighbourhood; leave one of them out",
                            "cut.tip_edge_length_m");
  }
  if (options.method == Method::kElement && options.width_m) {
    return invalid_argument("OPTIONS_CONFLICT", "cut.width_m needs method neighbourhood; leave one of them out",
                            "cut.width_m");
  }
  return Nothing{};
}

Status check_vertices(const mesh::TriangleMesh& mesh, const std::vector<mesh::VertexId>& vertices) {
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (vertices[i] >= 0 && vertices[i] < mesh.num_vertices()) continue;
    return invalid_argument("VERTEX_UNKNOWN",
                            "vertex " + std::to_string(vertices[i]) + " does not exist; the sheet has " +
                                std::to_string(mesh.num_vertices()),
                            "cut.fixed_vertices[" + std::to_string(i) + "]");
  }
  return Nothing{};
}

std::string metres(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g m", value);
  return text.data();
}

// Refuses a tolerance below a few hundred lattice units, which rounding alone would exceed.
Status check_tolerance(const PathScale& scale) {
  const double least = scale.representable_tolerance();
  if (scale.least_tolerance() >= least) return Nothing{};
  return invalid_argument("TOLERANCE_TOO_SMALL",
                          "the tolerance is " + metres(scale.least_tolerance()) +
                              "; positions on this sheet are rounded, so that " + metres(least) +
                              " is the least that can be kept",
                          "cut.tolerance_m");
}

Error curve_too_long(double achieved) {
  return invalid_argument("TOLERANCE_TOO_SMALL",
                          "4096 chords for each piece of the curve come only within " + metres(achieved) +
                              " of it; allow a larger tolerance, or split the curve into more pieces",
                          "cut.curve");
}

// Leaves out points of a path that comes from a picture, as far as the tolerance allows; the path has a point on every
// edge that it crosses. Triangles seen nearly edge-on can make its deviation more than half of the tolerance. Then that
// deviation is returned in `beside` (m), and the strokes count as exact. `flatness`: for cuts with a width, the
// deviation allowed to the strokes, m; the outline needs the rest of the tolerance.
FlatCurve leave_out_points(FlatCurve path, const PathScale& scale, std::optional<double> flatness, double& beside) {
  constexpr double kShareOfPicture = 0.5;  // -, fraction of the tolerance
  if (path.deviation_m > kShareOfPicture * flatness.value_or(scale.least_tolerance())) {
    beside = path.deviation_m;
    path.deviation_m = 0.0;
  }
  double moved = 0.0;
  for (Stroke& stroke : path.strokes) {
    Simplification simplification = flatness ? Simplification(stroke.points, path.deviation_m, *flatness)
                                             : Simplification(stroke.points, path.deviation_m, scale);
    simplification.simplify_stretch(0, stroke.points.size() - 1);
    stroke.points = simplification.kept_points();
    moved = std::max(moved, simplification.moved());
  }
  path.deviation_m += moved;
  return path;
}

// Returns the box that the curve is clipped to. It is a little larger than the sheet, and within the room of the plan.
Box room_of(const mesh::TriangleMesh& mesh, const CutPlan& plan) {
  const Eigen::AlignedBox2d& bounds = mesh.bounding_box();
  // An edge length keeps the ends clear of the border, but could lead out of the domain on a sheet of few triangles.
  const double clearance = std::min(plan.edge_length_m, kClipRoom * mesh.lattice().room());
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(clearance + plan.snap_m);
  Box around{bounds.min() - margin, bounds.max() + margin};
  if (!plan.room) return around;
  return {around.low.cwiseMax(plan.room->low), around.high.cwiseMin(plan.room->high)};
}

// Makes the outline of a strip, of the part that may reach into the box `room`.
Result<Outline> outline_near(const FlatCurve& curve, double width, const PathScale& scale, const Box& room) {
  const double of_width = kToleranceOfWidth * width;
  if (of_width < scale.representable_tolerance()) {
    return invalid_argument("WIDTH_TOO_SMALL",
                            "the width is " + metres(width) + "; positions on this sheet are rounded, so that " +
                                metres(scale.representable_tolerance() / kToleranceOfWidth) +
                                " is the least that can be kept",
                            "cut.width_m");
  }
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(0.5 * width);
  const FlatCurve near = clip(curve, {room.low - reach, room.high + reach});
  Result<Outline> strip = outline(near, width, std::min(kWidthFlattening * scale.least_flattening(), 0.5 * of_width));
  if (strip.ok() && strip->curve.deviation_m > scale.least_tolerance()) {
    return curve_too_long(strip->curve.deviation_m);
  }
  return strip;
}

}  // namespace

Result<CutPlan> plan(const mesh::TriangleMesh& mesh, const CutRequest& request) {
  KERF_TRY(validate(request.curve));
  KERF_TRY(check_options(request.options));
  KERF_TRY(check_range(request.snap, 1e-6, 0.1, "cut.snap"));
  KERF_TRY(check_range(request.max_vertices, 1.0, mesh::kMaxVertices, "cut.max_vertices"));
  KERF_TRY(check_vertices(mesh, request.fixed_vertices));
  if (request.view) KERF_TRY(validate(*request.view));
  if (request.view || request.most_shift) {
    KERF_CHECK(request.positions != nullptr && request.positions->cols() == mesh.num_vertices(),
               "a cut on a picture or of a bent sheet comes with the positions of the sheet");
  }

  CutPlan plan;
  plan.options = request.options;
  plan.room = request.room;
  plan.max_vertices = request.max_vertices;
  plan.snap = request.snap;
  plan.fixed_vertices = request.fixed_vertices;
  if (!std::is_sorted(plan.fixed_vertices.begin(), plan.fixed_vertices.end())) {
    std::sort(plan.fixed_vertices.begin(), plan.fixed_vertices.end());
  }
  plan.edge_length_m = mesh.base_edge_length();
  const PathScale scale(mesh, plan.options, plan.snap);
  plan.snap_m = scale.mean_snap();
  KERF_TRY(check_tolerance(scale));

  const bool is_by_element = plan.options.method == Method::kElement;
  const double share = is_by_element ? kElementFlattening : plan.options.width_m ? kWidthFlattening : 1.0;
  const double flatness = share * scale.least_flattening();
  FlatCurve whole;
  JoinOptions join{plan.options.join_m.value_or(0.0), 0.5 * plan.options.width_m.value_or(0.0), {}};
  if (request.view) {
    KERF_TRY_ASSIGN(ViewPath path,
                    project_onto_sheet(mesh, *request.positions, request.curve, *request.view, flatness));
    plan.layers = std::move(path.layers);
    plan.triangles_behind = path.behind;
    const auto most = plan.options.width_m ? std::optional(flatness) : std::nullopt;
    whole = leave_out_points(std::move(path.flat), scale, most, plan.view_deviation_m);
  } else {
    Curve curve = request.curve;
    if (request.options.fit) {
      KERF_TRY(place(mesh, *request.options.fit, curve));
    }
    whole = flatten(curve, flatness);
    join.kept_ends = kept_ends(curve);
  }
  // Ends of lines on a picture are where sight lines end, and mean nothing on the sheet unless they are to be joined.
  if (!request.view || plan.options.join_m) plan.joins = join_ends(mesh, scale, join, whole.strokes);
  KERF_TRY_ASSIGN(const FlatCurve flat, dashed(whole, plan.options.dash));
  const Box room = room_of(mesh, plan);
  ScaledCurve simplified;
  if (plan.options.width_m) {
    KERF_TRY_ASSIGN(Outline strip, outline_near(flat, *plan.options.width_m, scale, room));
    simplified.curve = clip(strip.curve, room);
    simplified.deviation_of_tolerance = simplified.curve.deviation_m / scale.least_tolerance();
    plan.outline = std::move(strip.curve.strokes);
    plan.strip_area_m2 = strip.area_m2;
  } else {
    const FlatCurve clipped = clip(flat, room);
    if (clipped.deviation_m > scale.least_tolerance()) return curve_too_long(clipped.deviation_m);
    if (is_by_element) {
      simplified = element_path(mesh, clipped, scale);
    } else if (plan.joins.joined_ends > 0) {
      // Ends lie on the chords as they are.
      simplified = {clipped, clipped.deviation_m / scale.least_tolerance()};
    } else {
      simplified = simplify(clipped, scale);
    }
  }
  if (spaced_size(simplified.curve, plan.edge_length_m) > kMaxPathPoints) {
    return resource_exhausted("CUT_ELEMENT_BUDGET",
                              "the cut is longer than 1 million edge lengths; split it into several", "cut.curve");
  }
  plan.strokes = std::move(simplified.curve.strokes);
  plan.curve_deviation_m = simplified.curve.deviation_m;
  plan.curve_deviation_of_tolerance = simplified.deviation_of_tolerance;
  if (request.most_shift && !is_by_element) {
    plan.kept_edges = bent_edges(mesh, plan.strokes, *request.positions, *request.most_shift);
  }
  return plan;
}

}  // namespace kerf::cut
