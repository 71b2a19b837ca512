#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "server/base/phase_observer.h"
#include "server/base/result.h"
#include "server/core/cut/curve.h"
#include "server/core/cut/dash.h"
#include "server/core/cut/fit.h"
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

// Ranges of the options that requests may set.
inline constexpr double kMinTolerance = 1.0e-6;              // -
inline constexpr double kMaxTolerance = 0.5;                 // -
inline constexpr double kMaxMinAngle = 28.0;                 // degrees
inline constexpr double kFineMinAngle = 25.0;                // degrees; CutOptions::min_angle_deg of fine quality
inline constexpr std::int32_t kMaxNewTriangles = 1'000'000;  // of one cut
inline constexpr double kMinLength = 1.0e-9;                 // m; least tolerance_m and tip_edge_length
inline constexpr double kMaxLength = 1.0e4;                  // m; largest of them
inline constexpr double kMinTipGrading = 1.05;               // -
inline constexpr double kMaxTipGrading = 10.0;               // -
inline constexpr double kMinWidth = 1.0e-9;                  // m
inline constexpr double kMaxWidth = 1.0e4;                   // m

// The two sides of a cut with a width lie where they should beside each other to within this part of it.  -
inline constexpr double kToleranceOfWidth = 0.125;

// Method of meshing around the path.
enum class Method {
  // Delaunay triangulation of the whole neighbourhood of the path, free old points moved away from it (see
  // CutOptions::relax), then Delaunay refinement to a smallest angle. Keeps the quality contract.
  kNeighbourhood,
  // Each crossed element by itself: its edges stay, and its inside is Delaunay. Then longest edges are bisected until
  // each triangle has l_max / l_min <= 3 or at most 3 % of the elements' area (ACDM). Promises no angle, ignores
  // min_angle_deg and relax. For comparison.
  kElement,
};

// Options of a cut beside its curve.
struct CutOptions {
  // Largest distance allowed between curve and lips, as a fraction of the sheet's edge length there
  // (mesh::EdgeLengths). -, in [kMinTolerance, kMaxTolerance]
  double tolerance = 0.02;
  // The same in metres; replaces `tolerance` where given.  m, in [1e-9, 1e4]
  std::optional<double> tolerance_m;
  // Refines triangles touched by the cut until no angle is smaller. Exceptions: corners below 60 degrees between lips,
  // and places near strands (StrandQuality). degrees, in [0, kMaxMinAngle]; 0 refines nothing
  double min_angle_deg = 20.0;
  // Moves free old points of the touched ring away from the path in rest space before refining, where that improves
  // the worst triangle around them. Needs far fewer and far less flat triangles; see MeshEdit::moved_vertices.
  bool relax = true;
  // New triangle slots one cut may take.  -, in [1, kMaxNewTriangles]
  std::int32_t max_new_triangles = 200'000;
  // Placement of the curve before it is cut; absent: the curve stays where it is.
  std::optional<Fit> fit;
  // Perforation: lengths of the curve that are cut in turn; without any all of it is cut.
  DashPattern dash;
  Method method = Method::kNeighbourhood;
  // Edge length wanted at the tips of the cut inside the sheet, where stresses peak; away from them it grows by
  // (tip_grading - 1) a unit of distance, so by about the factor tip_grading a ring of triangles. Absent: no grading.
  // m, in [kMinLength, kMaxLength]
  std::optional<double> tip_edge_length_m;
  double tip_grading = 1.5;  // -, in [kMinTipGrading, kMaxTipGrading]
  // Removes all material closer to the curve than half of this. A disc of that diameter sweeps it, with its centre on
  // the curve, dash by dash; so ends and corners are round. Vertices without any other material and whole pieces inside
  // the strip are gone, and their momentum with them. The strip follows the curve within the tolerance, and has this
  // width to within twice kToleranceOfWidth of it. Absent: the cut opens the sheet and removes nothing. m, in
  // [kMinWidth, kMaxWidth]
  std::optional<double> width_m = std::nullopt;
};

// Checks the ranges of the options: calls check(value, low, high, field) for each number, and returns the first error.
// `least_angle`: of min_angle_deg, degrees. Errors: those of `check`, and of validate() for `dash` and `fit`.
template <typename Check>
Status check_ranges(const CutOptions& options, double least_angle, const Check& check) {
  KERF_TRY(check(options.tolerance, kMinTolerance, kMaxTolerance, "cut.tolerance"));
  KERF_TRY(check(options.tolerance_m.value_or(1.0), kMinLength, kMaxLength, "cut.tolerance_m"));
  KERF_TRY(check(options.min_angle_deg, least_angle, kMaxMinAngle, "cut.min_angle_deg"));
  KERF_TRY(check(options.max_new_triangles, 1, kMaxNewTriangles, "cut.max_new_triangles"));
  KERF_TRY(check(options.tip_edge_length_m.value_or(1.0), kMinLength, kMaxLength, "cut.tip_edge_length_m"));
  KERF_TRY(check(options.tip_grading, kMinTipGrading, kMaxTipGrading, "cut.tip_grading"));
  KERF_TRY(check(options.width_m.value_or(1.0), kMinWidth, kMaxWidth, "cut.width_m"));
  KERF_TRY(validate(options.dash));
  return options.fit ? validate(*options.fit) : Nothing{};
}

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
  double curve_deviation_of_tolerance = 0.0;  // -; the same over the tolerance there, the largest of all places
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

enum class CutStatus {
  kApplied,
  kNoIntersection,  // the curve misses the sheet or only retraces existing border and lips. Or it is no larger than the
                    // snap distance, which makes it a point. Mesh untouched, edit empty
};

// Near strands vertices cost more than their angles gain. The smallest angle there is this part of
// CutOptions::min_angle_deg.  -
inline constexpr double kStrandAngle = 0.5;
// Distances of strands, as fractions of the edge length there (mesh::EdgeLengths).  -
inline constexpr double kNearStrands = 0.25;
inline constexpr double kNarrowGap = 0.03;

// Corners named in a reply; the sharpest first.
inline constexpr std::size_t kMaxListedCorners = 64;

// A corner between two lips, a lip and the border, or borders, below 60 degrees: no refinement can widen it, and
// triangles there may stay below the requested angle.
struct SharpCorner {
  Eigen::Vector2d position{0.0, 0.0};  // m, material coordinates
  double angle_deg = 0.0;              // degrees, in (0, 60); its sharpest one, where several meet
  std::int32_t triangles_below = 0;    // new triangles below the requested angle at it, or sharing a vertex with one
                                       // at it; one near two corners is counted at both
};

// Quality of the new triangles near strands: lips, or lips and the border, that face each other closer than
// kNearStrands, or lips that cross within it (mesh::Strands). No angle there is below kStrandAngle * min_angle_deg
// outside of sharp corners. Gaps narrower than kNarrowGap are spanned by needles of any angle.
struct StrandQuality {
  std::int32_t triangles_below = 0;     // below min_angle_deg, those in narrow gaps included
  std::int32_t narrow_below = 0;        // of those, in narrow gaps
  double asked_angle_deg = 0.0;         // degrees; smallest angle allowed; narrow gaps have no limit
  double min_angle_deg = 180.0;         // degrees; smallest angle of the worst outside of narrow gaps
  double narrow_min_angle_deg = 180.0;  // degrees; the same in narrow gaps
};

// The shapes of the new triangles: those the cut has made, not old ones that merely lost a neighbour.
struct CutQuality {
  std::int32_t triangles = 0;                 // measured
  double min_angle_deg = 180.0;               // degrees; smallest angle of the worst
  double mean_min_angle_deg = 180.0;          // degrees; mean of the smallest angles
  double max_aspect = 0.0;                    // -; worst longest edge / shortest height; at least 2 / sqrt(3)
  double mean_aspect = 0.0;                   // -
  double max_edge_ratio = 0.0;                // -; worst longest edge / shortest edge, which does not see flat caps
  double mean_edge_ratio = 0.0;               // -
  double min_height_m = 0.0;                  // m; smallest height
  std::int32_t triangles_below_angle = 0;     // below min_angle_deg of the options
  std::int32_t triangles_below_contract = 0;  // below the limit where they lie, near strands or elsewhere, outside of
                                              // two rings of sharp corners; 0 unless refinement_stopped
  std::vector<SharpCorner> corners;  // with triangles below the angle; the sharpest first, at most kMaxListedCorners
  std::int32_t num_corners = 0;      // of them all
  double elsewhere_min_angle_deg = 180.0;  // degrees; smallest angle of the worst that is not counted in `strands`
  StrandQuality strands;
};

struct CutReport {
  std::int32_t pieces = 0;               // connected pieces of the whole sheet after the cut
  std::int32_t new_vertices = 0;         // vertices of the opened mesh added
  std::int32_t new_triangles = 0;        // solid triangles added; those removed do not count
  std::int32_t rewritten_triangles = 0;  // slots rewritten, new ones included
  std::int32_t moved_vertices = 0;       // old vertices relaxed
  std::int32_t crossed_triangles = 0;    // solid triangles of the mesh before that the strokes run through
  std::int32_t new_lip_edges = 0;        // edges newly locked as lips, before refinement splits them
  double deviation_m = 0.0;              // m; proven bound on the distance between the curve (inside the sheet) and
                                         // its lips: flattening + snapping + rounding
  double deviation_of_tolerance = 0.0;   // -, in [0, 1]; the same over the tolerance there, the largest of all places
  bool refinement_stopped = false;       // a guard fired: the mesh is valid, its quality is below the request. At the
                                         // length floor of snap / 4
  // The next four also of a cut that misses.
  std::int32_t snapped_points = 0;   // path points moved onto an existing point or lip (by <= snap)
  std::int32_t closed_gaps = 0;      // stretches and points of the path laid on an older lip, the border or another
                                     // strand of it, which they did not meet exactly
  double widest_gap_m = 0.0;         // m, <= the snap distance there; how far off the farthest of those lay
  std::int32_t merged_segments = 0;  // path segments shorter than the snap distance that vanished ("dust")
  CutQuality quality;
  std::vector<ViewLayer> layers;       // of a cut on a picture: its connected stretches
  std::int32_t triangles_behind = 0;   // of a cut on a picture: as of CutPlan
  double view_deviation_m = 0.0;       // m; of a cut on a picture: as of CutPlan, part of deviation_m
  std::int32_t removed_triangles = 0;  // of a cut with a width: in the strip, once its sides were laid in
  std::int32_t removed_vertices = 0;   // of a cut with a width: left without material
  std::int32_t removed_pieces = 0;     // of a cut with a width: gone altogether
  double removed_area_m2 = 0.0;        // m^2; of a cut with a width
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
