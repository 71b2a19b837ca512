#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/cut/curve.h"
#include "server/core/mesh/ids.h"

// Data of cuts: the options of a request, apart from its curve, and the report on the cut. See cut.h for the functions.
namespace kerf::cut {

inline constexpr std::size_t kMaxDashLengths = 64;  // most lengths of a pattern
inline constexpr double kMinDashM = 1.0e-6;         // m, least length of a pattern
inline constexpr double kMaxDashM = 1.0e4;          // m, largest length of a pattern, and largest |offset|
inline constexpr double kMaxDashes = 10'000.0;      // most dashes of one cut

// A perforation: lengths that are cut and lengths that are left, alternately, as in SVG's stroke-dasharray.
struct DashPattern {
  std::vector<double> lengths;  // m, kMinDashM..kMaxDashM: cut, gap, cut, ...; a list of odd length is repeated once
  double offset = 0.0;          // m, +-kMaxDashM; place in the pattern where each stroke begins
};

// Errors, kInvalidArgument: DASH_OUT_OF_RANGE (field "cut.dash[2]" or "cut.dash_offset"), DASH_TOO_LONG (field
// "cut.dash").
Status validate(const DashPattern& pattern);

// Places a curve into a box, whatever its own size and place.
struct Fit {
  std::optional<Box>
      box;  // m, each side > 0; absent: the sheet's bounding box, made smaller by kFitMargin of a side at each end
};

// Errors, kInvalidArgument: FIT_OUT_OF_RANGE, FIT_EMPTY (field "cut.fit.max.x", for example).
Status validate(const Fit& fit);

inline constexpr double kFitMargin = 0.05;        // -
inline constexpr double kMinFitExtentM = 1.0e-9;  // m, least side of the box, and least larger side of the curve to fit

inline constexpr double kMaxViewportPx = 65'536.0;  // largest width, and largest height, of a picture

// Selects the layers of a folded sheet that are cut.
enum class LayerRule {
  kNearest,     // the visible layer: at every point of the curve the one nearest to the camera
  kAll,         // every layer
  kPiece,       // every layer of one connected piece
  kDepthRange,  // the parts of layers between two distances from the camera
};

// Camera of a picture, in the conventions of OpenGL.
struct View {
  Eigen::Matrix4d view = Eigen::Matrix4d::Identity();        // world -> camera: rotation and shift; the camera looks
                                                             // along -z
  Eigen::Matrix4d projection = Eigen::Matrix4d::Identity();  // camera -> clip space
  // Size of the picture, in (0, kMaxViewportPx]. Pixel (0, 0) is its top left corner, y points down.
  double width_px = 0.0;
  double height_px = 0.0;
  LayerRule layers = LayerRule::kNearest;
  std::int32_t piece = mesh::kNone;  // kPiece: the piece's number; kNone: the piece of the nearest layer where the
                                     // curve first meets the sheet
  double nearest_m = 0.0;            // kDepthRange: m from the camera, along its axis, in [0, farthest_m]
  double farthest_m = 0.0;
};

// Checks a view without a sheet. Errors, all kInvalidArgument with the field ("cut.view.projection"): VIEW_NOT_FINITE,
// VIEW_NOT_RIGID (`view` is not a rotation and shift, to 1e-6), VIEW_SINGULAR (`projection` cannot be inverted),
// VIEWPORT_OUT_OF_RANGE, DEPTH_RANGE, PIECE_UNKNOWN (below kNone).
Status validate(const View& view);

// Ranges of the options that requests may set.
inline constexpr double kMinTolerance = 1.0e-6;              // -
inline constexpr double kMaxTolerance = 0.5;                 // -
inline constexpr double kMaxMinAngle = 28.0;                 // degrees
inline constexpr double kFineMinAngle = 25.0;                // degrees; CutOptions::min_angle_deg for fine quality
inline constexpr std::int32_t kMaxNewTriangles = 1'000'000;  // largest value of CutOptions::max_new_triangles
inline constexpr double kMinLength = 1.0e-9;                 // m; least tolerance_m and tip_edge_length_m
inline constexpr double kMaxLength = 1.0e4;                  // m; largest tolerance_m and tip_edge_length_m
inline constexpr double kMinTipGrading = 1.05;               // -
inline constexpr double kMaxTipGrading = 10.0;               // -
inline constexpr double kMinWidth = 1.0e-9;                  // m
inline constexpr double kMaxWidth = 1.0e4;                   // m

// The distance between the two sides of a cut with a width may be wrong by twice this fraction of the width.  -
inline constexpr double kToleranceOfWidth = 0.125;

// Method of meshing around the path.
enum class Method {
  // Makes the whole neighbourhood of the path Delaunay, and moves free old points away from it (see CutOptions::relax).
  // Then refines to the smallest angle min_angle_deg. Keeps the promises on angles of CutOptions and StrandQuality.
  kNeighbourhood,
  // Remeshes each crossed element by itself: its edges stay, and its inside becomes Delaunay. Then bisects longest
  // edges (ACDM, see bisection.h). In the end each triangle is within ElementLimits: longest / shortest edge <= 3, or
  // at most 3 % of the area of an element. Promises no angle and ignores min_angle_deg and relax. It is meant for
  // comparison.
  kElement,
};

// Triangles that Method::kElement leaves as they are. Requests cannot change these limits; programs that compare
// methods can.
struct ElementLimits {
  double edge_ratio = 3.0;   // -, >= 1; longest over shortest edge up to which no triangle is bisected; may be infinite
  double area_ratio = 0.03;  // -, >= 0; area over that of an element there up to which no triangle is bisected
};

// Options of a cut, apart from its curve.
struct CutOptions {
  // Largest distance allowed between curve and lips, over the local edge length of the sheet (mesh::EdgeLengths). -, in
  // [kMinTolerance, kMaxTolerance]
  double tolerance = 0.02;
  // Largest distance allowed between curve and lips in metres; replaces `tolerance` if given.  m, in [kMinLength,
  // kMaxLength]
  std::optional<double> tolerance_m;
  // Smallest angle of triangles that the cut makes; they are refined until none is below it. Exceptions are corners
  // below 60 degrees between lips (SharpCorner) and places near strands (StrandQuality). degrees, in [0, kMaxMinAngle];
  // 0: no refinement
  double min_angle_deg = 20.0;
  // Before refinement, moves free old points beside the path in material space, if that improves the worst triangle
  // around them. The result has far fewer and far less flat triangles; see MeshEdit::moved_vertices.
  bool relax = true;
  // Most triangle slots that one cut may add, in [1, kMaxNewTriangles].
  std::int32_t max_new_triangles = 200'000;
  // Placement of the curve before it is cut; absent: the curve stays where it is.
  std::optional<Fit> fit;
  // Perforation: which lengths of the curve are cut. Without lengths the whole curve is cut.
  DashPattern dash;
  Method method = Method::kNeighbourhood;
  // Edge length wanted at tips, the ends of the cut inside the sheet, where stresses peak. It grows by (tip_grading -
  // 1) per distance from the tip, so by about the factor tip_grading from one ring of triangles to the next. Absent: no
  // grading. m, in [kMinLength, kMaxLength]
  std::optional<double> tip_edge_length_m;
  double tip_grading = 1.5;  // -, in [kMinTipGrading, kMaxTipGrading]
  // Width of the strip that the cut removes: all material closer to the curve than half of this. The strip is what a
  // disc sweeps whose centre follows the curve, dash by dash, so ends and corners are round. Vertices with no other
  // material, and whole pieces inside the strip, are removed with their momentum. The strip follows the curve within
  // the tolerance. Its width is right to twice kToleranceOfWidth, as a fraction. Absent: the cut opens the sheet and
  // removes nothing. m, in [kMinWidth, kMaxWidth]
  std::optional<double> width_m = std::nullopt;
  ElementLimits element_limits;  // for Method::kElement
  // Leads ends of lines on to the nearest place of another line of the curve, a lip or the border that is closer than
  // this. Absent: ends stay where they are. m, in [kMinLength, kMaxLength]
  std::optional<double> join_m = std::nullopt;
};

// Checks the ranges of the options: calls check(value, low, high, field) for each number, and returns the first error.
// `least_angle`: least value of min_angle_deg, degrees. Errors: those of `check`, and of validate() for `dash` and
// `fit`.
template <typename Check>
Status check_ranges(const CutOptions& options, double least_angle, const Check& check) {
  KERF_TRY(check(options.tolerance, kMinTolerance, kMaxTolerance, "cut.tolerance"));
  KERF_TRY(check(options.tolerance_m.value_or(1.0), kMinLength, kMaxLength, "cut.tolerance_m"));
  KERF_TRY(check(options.min_angle_deg, least_angle, kMaxMinAngle, "cut.min_angle_deg"));
  KERF_TRY(check(options.max_new_triangles, 1, kMaxNewTriangles, "cut.max_new_triangles"));
  KERF_TRY(check(options.tip_edge_length_m.value_or(1.0), kMinLength, kMaxLength, "cut.tip_edge_length_m"));
  KERF_TRY(check(options.tip_grading, kMinTipGrading, kMaxTipGrading, "cut.tip_grading"));
  KERF_TRY(check(options.width_m.value_or(1.0), kMinWidth, kMaxWidth, "cut.width_m"));
  KERF_TRY(check(options.join_m.value_or(1.0), kMinLength, kMaxLength, "cut.join_m"));
  KERF_TRY(validate(options.dash));
  return options.fit ? validate(*options.fit) : Nothing{};
}

// An end of a line that stays open is near if another line, lip or border is closer than this. It is over the local
// edge length. -
inline constexpr double kNearEnd = 0.1;

// Tells which ends of lines were led on, and which met nothing.
struct JoinReport {
  std::int32_t joined_ends = 0;  // ends led on to another line, a lip or the border
  double widest_join_m = 0.0;    // m; longest way by which an end was led on
  std::int32_t near_ends = 0;    // ends left open, closer than kNearEnd to another line, a lip or the border
  double nearest_end_m = 0.0;    // m; shortest distance of these
};

// One connected stretch of a cut on a picture. It lies on one layer, or continues from layer to layer around folds.
struct ViewLayer {
  std::int32_t piece = mesh::kNone;  // number of its piece before the cut
  double length_m = 0.0;             // m, length in material space
  double nearest_m = 0.0;            // m, least distance from the camera along its axis
  double farthest_m = 0.0;
  bool faces_camera = false;  // true if the camera sees the side on which triangles are counter-clockwise, where the
                              // stretch begins
};

enum class CutStatus {
  kApplied,
  kNoIntersection,  // the curve misses the sheet, only retraces border and lips, or is no larger than the snap
                    // distance. The mesh is unchanged and the edit empty
};

// Smallest angle near strands, over CutOptions::min_angle_deg. It is smaller there, since more vertices would cost more
// than better angles gain.  -
inline constexpr double kStrandAngle = 0.5;
// Widths of mesh::StrandWidths, over the local edge length (mesh::EdgeLengths): strands closer than kNearStrands are
// near, gaps below kNarrowGap are narrow.  -
inline constexpr double kNearStrands = 0.25;
inline constexpr double kNarrowGap = 0.03;

// Most corners that a reply lists; it lists the sharpest.
inline constexpr std::size_t kMaxListedCorners = 64;

// A corner below 60 degrees between lips or border. No refinement can widen it, so triangles there may stay below the
// requested angle.
struct SharpCorner {
  Eigen::Vector2d position{0.0, 0.0};  // m, material coordinates
  double angle_deg = 0.0;              // degrees, in (0, 60); the sharpest if several corners meet here
  std::int32_t triangles_below = 0;    // new triangles below the requested angle at this corner, or sharing a vertex
                                       // with a triangle at it; one near two corners counts at both
};

// Quality of the new triangles near strands, which are lips or borders close to each other. They face each other closer
// than kNearStrands, or lips cross within this distance (mesh::Strands). Away from sharp corners no angle there is
// below kStrandAngle * min_angle_deg. In gaps narrower than kNarrowGap any angle is allowed: needles span them.
struct StrandQuality {
  std::int32_t triangles_below = 0;     // triangles below min_angle_deg, also in narrow gaps
  std::int32_t narrow_below = 0;        // those of them in narrow gaps
  double asked_angle_deg = 0.0;         // degrees; smallest angle allowed; narrow gaps have no limit
  double min_angle_deg = 180.0;         // degrees; smallest angle of all counted triangles outside of narrow gaps
  double narrow_min_angle_deg = 180.0;  // degrees; smallest angle of all counted triangles in narrow gaps
};

// Measures the shapes of the triangles that a cut has made. Old triangles that merely lost a neighbour do not count.
struct CutQuality {
  std::int32_t triangles = 0;                 // number of triangles measured
  double min_angle_deg = 180.0;               // degrees; smallest angle of all triangles
  double mean_min_angle_deg = 180.0;          // degrees; mean over the triangles of their smallest angle
  double max_aspect = 0.0;                    // -; largest ratio of longest edge to least height of a triangle; at
                                              // least 2 / sqrt(3)
  double mean_aspect = 0.0;                   // -
  double max_edge_ratio = 0.0;                // -; largest ratio of longest to shortest edge of a triangle, which
                                              // misses flat caps
  double mean_edge_ratio = 0.0;               // -
  double min_height_m = 0.0;                  // m; least height of all triangles
  std::int32_t triangles_below_angle = 0;     // triangles with an angle below min_angle_deg of the options
  std::int32_t triangles_below_contract = 0;  // triangles below the angle allowed at their place, without those within
                                              // two rings of sharp corners; 0 unless refinement_stopped
  std::vector<SharpCorner> corners;           // corners with triangles below min_angle_deg; the sharpest first, at most
                                              // kMaxListedCorners
  std::int32_t num_corners = 0;               // all such corners
  double elsewhere_min_angle_deg = 180.0;     // degrees; smallest angle of all triangles not counted in `strands`
  StrandQuality strands;
};

struct CutReport {
  std::int32_t pieces = 0;               // connected pieces of the whole sheet after the cut
  std::int32_t new_vertices = 0;         // vertices added to the opened mesh
  std::int32_t new_triangles = 0;        // solid triangles in added slots; removed ones are not subtracted
  std::int32_t rewritten_triangles = 0;  // slots whose content changed, and new slots
  std::int32_t moved_vertices = 0;       // old vertices moved by relaxation
  std::int32_t crossed_triangles = 0;    // solid triangles before the cut that the strokes run through
  std::int32_t new_lip_edges = 0;        // edges first locked as lips, counted before refinement splits them
  double deviation_m = 0.0;              // m; proven bound on the distance between the curve inside the sheet and its
                                         // lips: flattening + snapping + rounding
  double deviation_of_tolerance = 0.0;   // -, in [0, 1]; largest ratio of that bound to the local tolerance
  bool refinement_stopped = false;       // refinement ended early, at its step limit or length floor (snap distance /
                                         // 4): the mesh is valid, its quality below the request
  // The next four are also set for a cut with kNoIntersection.
  std::int32_t snapped_points = 0;   // path points moved onto an existing point or lip, by at most the snap distance
  std::int32_t closed_gaps = 0;      // stretches and points of the path moved onto an older lip, the border or another
                                     // part of the path
  double widest_gap_m = 0.0;         // m; largest distance by which these were moved, at most the snap distance
  std::int32_t merged_segments = 0;  // path segments shorter than the snap distance that vanished ("dust")
  JoinReport joins;                  // as of CutPlan
  CutQuality quality;
  std::vector<ViewLayer> layers;       // for a cut on a picture: its connected stretches
  std::int32_t triangles_behind = 0;   // for a cut on a picture: as of CutPlan
  double view_deviation_m = 0.0;       // m; for a cut on a picture: as of CutPlan, included in deviation_m
  std::int32_t removed_triangles = 0;  // for a cut with a width: triangles of the strip, after its outline was put into
                                       // the mesh
  std::int32_t removed_vertices = 0;   // for a cut with a width: vertices left without material
  std::int32_t removed_pieces = 0;     // for a cut with a width: pieces removed as a whole
  double removed_area_m2 = 0.0;        // m^2; for a cut with a width: area of the removed triangles
};

}  // namespace kerf::cut
