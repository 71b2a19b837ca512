#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
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

// Cuts along a curve in material coordinates. The mesh stays welded in material space: the curve becomes a chain of
// locked edges (lips), and only the map from triangle corners to vertices separates the two sides. So re-cuts,
// crossings, junctions, punches, and cuts along an older lip or the border are all the same case: "meets a locked
// edge". An applied cut always opens. A cut of a single edge, with a tip at both ends, is split at its middle, since
// tips stay one vertex each.
//
// plan() only reads the mesh, apply() changes it. The mesh may change between the two: apply() works on its current
// state.
namespace kerf::cut {

// Most by which the flip of an edge may move a sheet in space, m, >= 0. Edges beyond that are split instead, so that a
// bent sheet keeps its shape.
struct ShiftLimit {
  double near = 0.0;   // m, where something that the sheet touches may be near
  double apart = 0.0;  // m, elsewhere; >= near
  std::span<const std::uint8_t>
      is_apart{};  // by vertex: 1 where nothing is near; vertices beyond its end are not apart
};

struct CutRequest {
  Curve curve;
  CutOptions options;
  // Vertices whose material coordinates must not change, as they are pinned or grabbed. In any order.
  std::vector<mesh::VertexId> fixed_vertices;
  // The camera of a picture of the sheet, in pixels of which `curve` is given. Absent: `curve` is in material
  // coordinates.
  std::optional<View> view = std::nullopt;
  const linear::VertexField* positions = nullptr;  // 3 x V, m, world; needed for `view` and `most_shift`
  // Limit for edges near the path. Where edges exceed it, refinement asks for half of min_angle_deg. Absent: the
  // material plane alone decides.
  std::optional<ShiftLimit> most_shift = std::nullopt;
  // Box that the cut does not leave, m, material coordinates. Its sides must not cross the sheet. Absent: all of the
  // sheet may be cut.
  std::optional<Box> room = std::nullopt;
  // Most vertices that the opened mesh may have after the cut, in [1, mesh::kMaxVertices].
  std::int32_t max_vertices = mesh::kMaxVertices;
  // Snap distance over the local edge length: the path is laid on points and lips that are closer than this. It never
  // uses more than a tenth of the tolerance. -, in [1e-6, 0.1]
  double snap = 1.0e-3;
};

// Input of apply(): the curve, flattened and clipped to the neighbourhood of the sheet. A plain value.
struct CutPlan {
  std::vector<Stroke> strokes;     // m, material coordinates; empty if the curve is nowhere near the sheet. For a cut
                                   // with a width: the strip's outline, clipped
  std::vector<Stroke> outline;     // for a cut with a width: the whole outline of the strip
  double strip_area_m2 = 0.0;      // m^2; for a cut with a width: the area inside the outline
  double curve_deviation_m = 0.0;  // m; proven bound on the distance between curve and strokes
  double curve_deviation_of_tolerance = 0.0;  // -; largest ratio of the distance between curve and strokes to the local
                                              // tolerance
  double edge_length_m = 0.0;                 // m; the sheet's mean edge length
  double snap_m = 0.0;  // m; snap distance where edges are edge_length_m long; elsewhere it is in proportion
  CutOptions options;
  std::optional<Box> room;                               // as of CutRequest
  std::int32_t max_vertices = mesh::kMaxVertices;        // as of CutRequest
  double snap = 1.0e-3;                                  // as of CutRequest
  std::vector<mesh::VertexId> fixed_vertices;            // sorted
  std::vector<std::array<mesh::PointId, 2>> kept_edges;  // by their ends: edges that may be split, but not flipped
  JoinReport joins;                                      // ends of the curve's lines
  std::vector<ViewLayer> layers;                         // for a cut on a picture
  std::int32_t triangles_behind = 0;  // for a cut on a picture: triangles left out, as they reach behind the camera
  double view_deviation_m = 0.0;  // m; bound on the distance between sight lines and strokes, if this would take too
                                  // much of the tolerance, as in a picture nearly edge-on; curve_deviation_m then
                                  // leaves it out. Else 0
};

struct CutOutcome {
  CutStatus status = CutStatus::kNoIntersection;
  mesh::MeshEdit edit;
  mesh::UndoLog undo;
  CutReport report;
};

// Checks the request and flattens the curve. Reads the mesh, and `positions` if there is a view.
// Errors: kInvalidArgument: those of validate(), fit_into() and project_onto_sheet(); OPTION_OUT_OF_RANGE
//         ("cut.min_angle_deg"), OPTIONS_CONFLICT, VERTEX_UNKNOWN; TOLERANCE_TOO_SMALL and WIDTH_TOO_SMALL (rounding to
//         the lattice, or the limit on chords, does not allow it);
//         kResourceExhausted: TOO_MANY_DASHES, VIEW_WORK_BUDGET, WIDTH_WORK_BUDGET, and CUT_ELEMENT_BUDGET for a cut
//         that is too long.
Result<CutPlan> plan(const mesh::TriangleMesh& mesh, const CutRequest& request);

// Carries out the plan, or leaves the mesh bit for bit as it was. If snapping led beyond the tolerance, or a crossing
// could not be rounded, the cut is tried again, at most twice. Each attempt has a shorter snap distance.
// Errors: kResourceExhausted CUT_ELEMENT_BUDGET (max_new_triangles, or the mesh's own limit, or a step counter) and
//         TOO_MANY_VERTICES (max_vertices);
//         kFailedPrecondition CUT_NOT_REPRESENTABLE (a crossing could not be rounded to a valid point: shift the
//         curve), TOLERANCE_NOT_KEPT (snapping many times over led the path too far away: shift the curve) and
//         STRIP_COVERS_SHEET (nothing would be left).
// With KERF_VALIDATE defined every mesh invariant is checked afterwards.
// `observer` may be null.
Result<CutOutcome> apply(mesh::TriangleMesh& mesh, const CutPlan& plan, PhaseObserver* observer = nullptr);

}  // namespace kerf::cut
