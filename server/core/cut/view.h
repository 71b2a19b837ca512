#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/cut/curve.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/triangle_mesh.h"

// Cuts drawn on a picture: a curve in pixels that sweeps along the rays of a camera through the deformed sheet.
namespace kerf::cut {

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

// One connected stretch of the cut on one layer, or on several that it runs through around folds.
struct ViewLayer {
  std::int32_t piece = mesh::kNone;  // before the cut
  double length_m = 0.0;             // m, in rest space
  double nearest_m = 0.0;            // m, along the camera's axis
  double farthest_m = 0.0;
  bool faces_camera = false;  // where it begins: the side on which the triangles are counter-clockwise is seen
};

// Checks a view by itself. Errors, all kInvalidArgument with the field ("cut.view.projection"): VIEW_NOT_FINITE,
// VIEW_NOT_RIGID (`view` is no rotation and shift, to 1e-6), VIEW_SINGULAR (`projection` cannot be inverted),
// VIEWPORT_OUT_OF_RANGE, DEPTH_RANGE, PIECE_UNKNOWN (< kNone).
Status validate(const View& view);

// A screen curve on the sheet.
struct ViewPath {
  FlatCurve flat;                 // m, material coordinates; strokes parallel to `layers`
  std::vector<ViewLayer> layers;  // in the order in which the curve meets them
  std::int32_t behind = 0;        // triangles not looked at: they reach behind the camera
};

// Lays `curve` (pixels) onto the sheet with its vertices at `positions` (3 x V, m, world) as `view` sees it. Strokes
// follow the curve's image within flat.deviation_m. The curve is flattened to keep this below `tolerance` (m, > 0).
// That is not guaranteed: triangles seen nearly edge-on can make it larger.
//
// Within one triangle the map from picture to rest space is a homography, so a straight piece stays straight: only
// where the curve crosses edges are nodes computed, once an edge, so that neighbours agree. Which edges are crossed is
// decided exactly, on screen positions rounded to a lattice, the curve shifted by a symbolic infinitesimal: there are
// no ties.
// Errors: those of validate(curve); kResourceExhausted VIEW_WORK_BUDGET: too many pairs of triangles and curve segments
// meet; PIECE_UNKNOWN.
Result<ViewPath> lay_on_sheet(const mesh::TriangleMesh& mesh, const mesh::VertexField& positions, const Curve& curve,
                              const View& view, double tolerance);

}  // namespace kerf::cut
