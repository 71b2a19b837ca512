#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/cut/curve.h"
#include "server/core/mesh/ids.h"

// Data of cuts: the options of a request beside its curve, and the report on what was done. See cut.h for the work
// itself.
namespace kerf::cut {

inline constexpr std::size_t kMaxDashLengths = 64;  // entries of a pattern
inline constexpr double kMinDashM = 1.0e-6;         // m, an entry
inline constexpr double kMaxDashM = 1.0e4;          // m, an entry, and the offset either way
inline constexpr double kMaxDashes = 10'000.0;      // dashes that one cut is divided into

// A perforation: lengths that are cut and lengths that are left, in turn, as SVG's stroke-dasharray.
struct DashPattern {
  std::vector<double> lengths;  // m, kMinDashM..kMaxDashM; cut, gap, cut, ... an odd number of them counts twice
  double offset = 0.0;          // m, +-kMaxDashM; how far into the pattern each stroke begins
};

// Errors, kInvalidArgument: DASH_OUT_OF_RANGE ("cut.dash[2]", "cut.dash_offset"), DASH_TOO_LONG ("cut.dash").
Status validate(const DashPattern& pattern);

// Target placement of a curve, independent of its own size and place.
struct Fit {
  std::optional<Box>
      box;  // m, each side > 0; absent: the sheet's bounding box less kFitMargin of each side at each end
};

// Errors, kInvalidArgument: FIT_OUT_OF_RANGE, FIT_EMPTY ("cut.fit.max.x").
Status validate(const Fit& fit);

inline constexpr double kFitMargin = 0.05;        // -
inline constexpr double kMinFitExtentM = 1.0e-9;  // m, of the larger side of a curve that is fitted

inline constexpr double kMaxViewportPx = 65'536.0;  // a side

// Selects the layers of a folded sheet that are cut.
enum class LayerRule {
  kNearest,     // what is seen: at every point of the curve the layer nearest to the camera
  kAll,         // every layer
  kPiece,       // every layer of one connected piece
  kDepthRange,  // what lies between two distances from the camera
};

// Camera of a picture, in the conventions of OpenGL.
struct View {
  Eigen::Matrix4d view = Eigen::Matrix4d::Identity();        // world -> camera: rotation and shift; looks along -z
  Eigen::Matrix4d projection = Eigen::Matrix4d::Identity();  // camera -> clip
  // Size of the picture, in (0, kMaxViewportPx]. Pixel (0, 0) is its top left corner, y points down.
  double width_px = 0.0;
  double height_px = 0.0;
  LayerRule layers = LayerRule::kNearest;
  std::int32_t piece = mesh::kNone;  // kPiece: the piece's number; kNone: that of the nearest layer where the curve
                                     // first meets the sheet
  double nearest_m = 0.0;            // kDepthRange: m, along the camera's axis, in [0, farthest_m]
  double farthest_m = 0.0;
};

// Checks a view by itself. Errors, all kInvalidArgument with the field ("cut.view.projection"): VIEW_NOT_FINITE,
// VIEW_NOT_RIGID (`view` is no rotation and shift, to 1e-6), VIEW_SINGULAR (`projection` cannot be inverted),
// VIEWPORT_OUT_OF_RANGE, DEPTH_RANGE, PIECE_UNKNOWN (< kNone).
Status validate(const View& view);

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
  // Largest distance allowed between curve and lips, in metres; replaces `tolerance` where given.  m, in [1e-9, 1e4]
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

// One connected stretch of the cut on one layer, or on several that it runs through around folds.
struct ViewLayer {
  std::int32_t piece = mesh::kNone;  // before the cut
  double length_m = 0.0;             // m, in rest space
  double nearest_m = 0.0;            // m, along the camera's axis
  double farthest_m = 0.0;
  bool faces_camera = false;  // where it begins: the side on which the triangles are counter-clockwise is seen
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

// Measures the shapes of the triangles that a cut has made. Old triangles that merely lost a neighbour do not count.
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
  double deviation_of_tolerance = 0.0;   // -, in [0, 1]; largest ratio of that distance to the tolerance at its place
  bool refinement_stopped = false;       // a guard fired: the mesh is valid, its quality is below the request. At the
                                         // length floor of snap / 4
  // The next four also of a cut that misses.
  std::int32_t snapped_points = 0;   // path points moved onto an existing point or lip (by <= snap)
  std::int32_t closed_gaps = 0;      // stretches and points of the path laid on an older lip, the border or another
                                     // strand of it, which they did not meet exactly
  double widest_gap_m = 0.0;         // m; largest distance of these from where they were laid, <= the snap distance
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

}  // namespace kerf::cut
