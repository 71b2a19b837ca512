#include "server/core/cut/view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include <Eigen/LU>

#include "server/core/cut/view_chains.h"
#include "server/core/cut/view_crossings.h"
#include "server/core/cut/view_layers.h"

namespace kerf::cut {
namespace {

constexpr double kRigid = 1.0e-6;            // -; largest entry of R^T R - 1, R the rotation of the view
constexpr double kFirstFlatnessPx = 0.25;    // px
constexpr double kLeastFlatnessPx = 1.0e-3;  // px
constexpr double kFlatnessShare = 0.4;       // -; fraction of the tolerance for flattening; the rest is for leaving out
                                             // points
constexpr int kMaxFlattenings = 3;
// Bound on the rounding of vertices and curve to the lattice of Screen, with its jitter. px
constexpr double kScreenErrorPx = 2.0 * (Screen::kJitter + 1) / Screen::kUnitsPerPx;

// Returns a bound (m) on the distance between the images on the sheet of a curve and of a polyline within `px` pixels
// of it.
double bound_on_sheet(const std::vector<ViewStretch>& stretches, double px) {
  double bound = 0.0;
  for (const ViewStretch& stretch : stretches) {
    bound = std::max(bound, std::min(stretch.m_per_px * px, stretch.longest_m));
  }
  return bound;
}

}  // namespace

Status validate(const View& view) {
  const std::array<std::pair<double, const char*>, 2> sides{
      {{view.width_px, "cut.view.width_px"}, {view.height_px, "cut.view.height_px"}}};
  for (const auto& [side, field] : sides) {
    if (!(side > 0.0 && side <= kMaxViewportPx)) {
      return invalid_argument("VIEWPORT_OUT_OF_RANGE",
                              std::string(field) + " is " + std::to_string(side) + "; it must be in (0, 65536]", field);
    }
  }
  if (!view.view.allFinite()) return invalid_argument("VIEW_NOT_FINITE", "a number is not finite", "cut.view.view");
  if (!view.projection.allFinite()) {
    return invalid_argument("VIEW_NOT_FINITE", "a number is not finite", "cut.view.projection");
  }
  const Eigen::Matrix3d rotation = view.view.topLeftCorner<3, 3>();
  const Eigen::RowVector4d last(0.0, 0.0, 0.0, 1.0);
  if ((rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > kRigid ||
      (view.view.row(3) - last).cwiseAbs().maxCoeff() > kRigid || rotation.determinant() < 0.0) {
    return invalid_argument("VIEW_NOT_RIGID",
                            "the view matrix must be a rotation and a shift, its last row 0 0 0 1; scales belong in "
                            "the projection (16 numbers, column by column)",
                            "cut.view.view");
  }
  const double largest = view.projection.cwiseAbs().maxCoeff();
  if (!(largest > 0.0) || !Eigen::FullPivLU<Eigen::Matrix4d>(view.projection / largest).isInvertible()) {
    return invalid_argument("VIEW_SINGULAR", "the projection matrix cannot be inverted", "cut.view.projection");
  }
  if (!std::isfinite(view.nearest_m)) {
    return invalid_argument("VIEW_NOT_FINITE", "a number is not finite", "cut.view.nearest_m");
  }
  if (!std::isfinite(view.farthest_m)) {
    return invalid_argument("VIEW_NOT_FINITE", "a number is not finite", "cut.view.farthest_m");
  }
  if (view.layers == LayerRule::kDepthRange && !(view.nearest_m >= 0.0 && view.nearest_m <= view.farthest_m)) {
    return invalid_argument("DEPTH_RANGE", "a depth range needs 0 <= nearest_m <= farthest_m", "cut.view.nearest_m");
  }
  if (view.piece < mesh::kNone) {
    return invalid_argument("PIECE_UNKNOWN", "pieces are numbered from 0", "cut.view.piece");
  }
  return Nothing{};
}

Result<ViewPath> project_onto_sheet(const mesh::TriangleMesh& mesh, const linear::VertexField& positions,
                                    const Curve& curve, const View& view, double tolerance) {
  if (view.layers == LayerRule::kPiece && view.piece >= mesh.num_pieces()) {
    return invalid_argument("PIECE_UNKNOWN",
                            "cut.view.piece is " + std::to_string(view.piece) + "; the sheet has pieces 0.." +
                                std::to_string(mesh.num_pieces() - 1),
                            "cut.view.piece");
  }
  const Screen screen = project(positions, view);
  double flatness = kFirstFlatnessPx;
  FlatCurve on_screen;
  ViewCrossings crossings;
  for (int attempt = 0; attempt < kMaxFlattenings; ++attempt) {
    on_screen = flatten(curve, flatness);
    KERF_TRY_ASSIGN(crossings, find_crossings(mesh, screen, on_screen.strokes));
    const double wanted = kFlatnessShare * tolerance;
    const double reached = bound_on_sheet(crossings.stretches, on_screen.deviation_m);
    if (reached <= wanted || flatness <= kLeastFlatnessPx) break;
    flatness = std::max(0.5 * on_screen.deviation_m * wanted / reached, kLeastFlatnessPx);
  }
  ViewPath path;
  path.behind = crossings.behind;
  path.flat.deviation_m = bound_on_sheet(crossings.stretches, on_screen.deviation_m + kScreenErrorPx);
  for (ViewChain& chain : link(select_layers(mesh, view, std::move(crossings.intervals)))) {
    ViewLayer layer = chain.layer;
    layer.piece = mesh.piece(chain.first_triangle);
    layer.faces_camera = faces_camera(mesh, screen, chain.first_triangle);
    if (chain.points.size() < 2) continue;
    path.flat.strokes.push_back({std::move(chain.points)});
    path.layers.push_back(layer);
  }
  return path;
}

}  // namespace kerf::cut
