#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "server/base/phase_observer.h"
#include "server/base/result.h"
#include "server/core/cut/curve.h"
#include "server/core/cut/cut_types.h"
#include "server/core/cut/view.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/mesh_editor.h"
#include "server/core/mesh/triangle_mesh.h"

// Cuts along a curve in material coordinates. The mesh stays welded in rest space: the curve becomes a chain of locked
// edges (lips), and only the map from triangle corners to vertices separates the two sides. So re-cuts, crossings, T
// and X junctions, punches, cuts along an older lip or along the border are one case each time: "meets a locked edge".
// An applied cut always opens: one that would be a single edge inside, both ends of it tips, is split at its middle.
//
// plan() only reads the mesh, apply() changes it. The mesh may change between the two: apply() works on its current
// state.
namespace kerf::cut {

struct CutRequest {
  Curve curve;
  CutOptions options;
  // Vertices whose rest position must stay (pinned, grabbed). In any order.
  std::vector<mesh::VertexId> fixed_vertices;
  // Present: `curve` is in pixels of this picture of the sheet, whose vertices are at `positions` (3 x V, m, world;
  // read by plan() only, and only then).
  std::optional<View> view = std::nullopt;
  const mesh::VertexField* positions = nullptr;
  // Vertices of the opened mesh after the cut.  -, in [1, mesh::kMaxVertices]
  std::int32_t max_vertices = mesh::kMaxVertices;
  // Snap distance: the path is laid on points and lips closer than this fraction of the local edge length. It is never
  // above a tenth of the tolerance. -, in [1e-6, 0.1]
  double snap = 1.0e-3;
};

// Input of apply(): the curve, flattened and clipped to the neighbourhood of the sheet. A plain value.
struct CutPlan {
  std::vector<Stroke> strokes;     // m, material coordinates; empty where the curve is nowhere near the sheet. Of a cut
                                   // with a width: its outline
  std::vector<Stroke> outline;     // of a cut with a width: the whole of it, not clipped
  double strip_area_m2 = 0.0;      // m^2; of a cut with a width: inside the outline
  double curve_deviation_m = 0.0;  // m; proven bound on the distance between curve and strokes
  double curve_deviation_of_tolerance = 0.0;  // -; the largest ratio of that distance to the tolerance at its place
  double edge_length_m = 0.0;                 // m; the sheet's mean edge length
  double snap_m = 0.0;  // m; distance below which the path is laid on points and lips where edges are so
                        // long; elsewhere in proportion
  CutOptions options;
  std::int32_t max_vertices = mesh::kMaxVertices;  // as of CutRequest
  double snap = 1.0e-3;                            // as of CutRequest
  std::vector<mesh::VertexId> fixed_vertices;      // sorted
  std::vector<ViewLayer> layers;                   // of a cut on a picture
  std::int32_t triangles_behind = 0;  // of a cut on a picture: left out, since they reach behind the camera
  double view_deviation_m = 0.0;      // m; of a cut on a picture that shows the sheet nearly edge-on: beyond
                                      // the tolerance, bound on the distance between sight lines and strokes
};

struct CutOutcome {
  CutStatus status = CutStatus::kNoIntersection;
  mesh::MeshEdit edit;
  mesh::UndoLog undo;
  CutReport report;
};

// Validates and flattens. Reads the mesh for its extent and edge length only.
// Errors, kInvalidArgument: those of validate() and fit_into(), OPTION_OUT_OF_RANGE ("cut.min_angle_deg"),
// OPTIONS_CONFLICT, VERTEX_UNKNOWN, and TOLERANCE_TOO_SMALL and WIDTH_TOO_SMALL, which the lattice or the number of
// chords cannot keep;
// kResourceExhausted: TOO_MANY_DASHES, VIEW_WORK_BUDGET, WIDTH_WORK_BUDGET, and CUT_ELEMENT_BUDGET for a cut that is
// too long.
Result<CutPlan> plan(const mesh::TriangleMesh& mesh, const CutRequest& request);

// Carries the plan out, or leaves the mesh bit-identical. If snapping led beyond the requested tolerance, or a crossing
// could not be rounded, the cut is repeated. This happens at most twice, each time with a shorter snap distance.
// Errors: kResourceExhausted CUT_ELEMENT_BUDGET (max_new_triangles, or the mesh's own limit, or a step counter) and
//         TOO_MANY_VERTICES (max_vertices);
//         kFailedPrecondition CUT_NOT_REPRESENTABLE (a crossing could not be rounded to a valid point: shift the
//         curve), TOLERANCE_NOT_KEPT (snapping many times over led the path too far away: shift the curve) and
//         STRIP_COVERS_SHEET (nothing would be left).
// With KERF_VALIDATE defined every mesh invariant is checked afterwards.
// `observer` may be null.
Result<CutOutcome> apply(mesh::TriangleMesh& mesh, const CutPlan& plan, PhaseObserver* observer = nullptr);

}  // namespace kerf::cut
