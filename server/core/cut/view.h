#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/cut/cut_types.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/triangle_mesh.h"

// Cuts drawn on a picture: a curve in pixels that sweeps along the rays of a camera through the deformed sheet.
namespace kerf::cut {

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
Result<ViewPath> project_onto_sheet(const mesh::TriangleMesh& mesh, const mesh::VertexField& positions,
                                    const Curve& curve, const View& view, double tolerance);

}  // namespace kerf::cut
