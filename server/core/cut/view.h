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

// A curve of a picture, laid on the sheet.
struct ViewPath {
  FlatCurve flat;                 // m, material coordinates; stroke i belongs to layers[i]
  std::vector<ViewLayer> layers;  // in the order in which the curve meets them
  std::int32_t behind = 0;        // triangles left out, as they reach behind the camera
};

// Lays `curve` (pixels) onto the sheet with its vertices at `positions` (3 x V, m, world) as `view` sees it. Strokes
// follow the image of the curve on the sheet within flat.deviation_m. The curve is flattened to keep this below
// `tolerance` (m, > 0), but triangles seen nearly edge-on can make it larger.
//
// Within one triangle the map from picture to material space is a homography, so straight pieces stay straight. So
// points are computed only where the curve crosses edges, in the same way for both triangles at an edge. Exact
// predicates decide which edges are crossed, on screen positions rounded to a lattice. The curve counts as shifted by
// an infinitesimal amount, so there are no ties.
// Errors: those of validate(curve); kInvalidArgument PIECE_UNKNOWN; kResourceExhausted VIEW_WORK_BUDGET (too many pairs
// of a triangle and a curve segment).
Result<ViewPath> project_onto_sheet(const mesh::TriangleMesh& mesh, const linear::VertexField& positions,
                                    const Curve& curve, const View& view, double tolerance);

}  // namespace kerf::cut
