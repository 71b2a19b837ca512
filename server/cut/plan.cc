#include <algorithm>
#include <cmath>
#include <string>

#include "server/cut/cut.h"
#include "server/cut/stroke.h"

namespace kerf::cut {
namespace {

constexpr double kMaxPathPoints = 1.0e6;  // points of a spaced path; more cannot fit in any element budget

// Most of the room around the sheet that clipping leaves to a curve, the snap distance aside: that is at most a tenth
// of the edge length, and the edge length at most sqrt(2) times the room.  -
constexpr double kClipRoom = 0.25;

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
  if (Status s = check_range(options.tolerance, kMinTolerance, kMaxTolerance, "cut.tolerance"); !s.ok()) return s;
  if (Status s = check_range(options.tolerance_m.value_or(1.0), 1e-9, 1e4, "cut.tolerance_m"); !s.ok()) return s;
  if (Status s = check_range(options.snap, 1e-6, 0.1, "cut.snap"); !s.ok()) return s;
  if (Status s = check_range(options.min_angle_deg, 0.0, kMaxMinAngle, "cut.min_angle_deg"); !s.ok()) return s;
  if (Status s =
          check_range(static_cast<double>(options.max_new_triangles), 1.0, kMaxNewTriangles, "cut.max_new_triangles");
      !s.ok()) {
    return s;
  }
  if (Status s = validate(options.dash); !s.ok()) return s;
  if (options.fit) {
    if (Status s = validate(*options.fit); !s.ok()) return s;
  }
  return check_range(options.max_vertices, 1.0, mesh::kMaxVertices, "cut.max_vertices");
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

}  // namespace

Result<CutPlan> plan(const mesh::TriangleMesh& mesh, const CutRequest& request) {
  if (Status s = validate(request.curve); !s.ok()) return s.error();
  if (Status s = check_options(request.options); !s.ok()) return s.error();
  if (Status s = check_vertices(mesh, request.fixed_vertices); !s.ok()) return s.error();
  if (request.view) {
    if (Status s = validate(*request.view); !s.ok()) return s.error();
    KERF_CHECK(request.positions != nullptr && request.positions->cols() == mesh.num_vertices(),
               "a cut on a picture comes with the positions of the sheet");
  }

  CutPlan plan;
  plan.options = request.options;
  plan.fixed_vertices = request.fixed_vertices;
  std::sort(plan.fixed_vertices.begin(), plan.fixed_vertices.end());
  plan.fixed_vertices.erase(std::unique(plan.fixed_vertices.begin(), plan.fixed_vertices.end()),
                            plan.fixed_vertices.end());
  // The length of the sheet as built, which cuts leave alone: the same curve is flattened and spaced the same way every
  // time, so a second identical cut meets the lips of the first exactly.
  plan.edge_length_m = mesh.base_edge_length();
  const double tolerance = plan.options.tolerance_m.value_or(plan.options.tolerance * plan.edge_length_m);
  // Two clearances of the lattice keep a point that did not snap to a lip insertable beside it.
  const double smallest_snap = 2.0 * static_cast<double>(mesh::MeshEditor::kLockClearance) * mesh.lattice().spacing;
  plan.snap_m = std::max(std::min(plan.options.snap * plan.edge_length_m, 0.1 * tolerance), smallest_snap);

  const double flatness = std::max(tolerance - plan.snap_m, 0.1 * tolerance);
  FlatCurve whole;
  if (request.view) {
    Result<ViewPath> path = lay_on_sheet(mesh, *request.positions, request.curve, *request.view, flatness);
    if (!path.ok()) return path.error();
    whole = std::move(path->flat);
    plan.layers = std::move(path->layers);
    plan.triangles_behind = path->behind;
  } else {
    Curve curve = request.curve;
    if (request.options.fit) {
      if (Status s = place(mesh, *request.options.fit, curve); !s.ok()) return s.error();
    }
    whole = flatten(curve, flatness);
  }
  const Result<FlatCurve> flat = dashed(whole, plan.options.dash);
  if (!flat.ok()) return flat.error();
  const Eigen::AlignedBox2d& bounds = mesh.bounding_box();
  // An edge length keeps ends outside clear of the border, but on a sheet of few triangles that leads out of the
  // domain.
  const double clearance = std::min(plan.edge_length_m, kClipRoom * mesh.lattice().room());
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(clearance + plan.snap_m);
  FlatCurve clipped = clip(*flat, {bounds.min() - margin, bounds.max() + margin});
  if (spaced_size(clipped, plan.edge_length_m) > kMaxPathPoints) {
    return Error{ErrorCode::kResourceExhausted, "CUT_ELEMENT_BUDGET",
                 "the cut is longer than 1 million edge lengths; split it into several", "cut.curve"};
  }
  plan.strokes = std::move(clipped.strokes);
  plan.curve_deviation_m = clipped.deviation_m;
  return plan;
}

}  // namespace kerf::cut
