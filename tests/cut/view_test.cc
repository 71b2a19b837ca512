#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/cut/cut.h"
#include "server/core/cut/view.h"
#include "tests/cut/view_scenes.h"

// Cuts drawn on a picture of a flat, a folded, a tilted, a far and a hidden sheet.
namespace kerf::cut {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(ViewCut, FollowsTheRaysToAFlatSheet) {
  const Scene s = scene(20, lay_flat);
  SeededRandom random(5);
  for (int trial = 0; trial < 50; ++trial) {
    const auto uniform = [&](double low, double high) { return low + (high - low) * random.uniform(); };
    const View view = view_from({uniform(-1.5, 2.5), uniform(-1.5, 2.5), uniform(0.7, 3.0)}, {0.5, 0.5, 0.0});
    // A curve whose image in the plane z = 0 is known: rays are cast back with the inverse of the whole map.
    CubicBezier curve;
    for (const Vector2d& at : {Vector2d(0.2, 0.3), Vector2d(0.4, 0.9), Vector2d(0.6, 0.1), Vector2d(0.8, 0.6)}) {
      curve.points.push_back(pixel(view, lay_flat(at + 0.05 * Vector2d(random.uniform(), random.uniform()))));
    }
    const ViewPath path = lay(s, curve, view);
    ASSERT_EQ(path.flat.strokes.size(), 1u);
    EXPECT_LE(path.flat.deviation_m, 1e-3);
    const Matrix4d all = view.projection * view.view;
    Eigen::Matrix3d plane;  // (x, y, 1) in z = 0 -> clip (x, y, w)
    for (int row = 0; row < 3; ++row) {
      const int of = row == 2 ? 3 : row;
      plane.row(row) << all(of, 0), all(of, 1), all(of, 3);
    }
    const Eigen::Matrix3d back = plane.inverse();
    double farthest = 0.0;
    for (int i = 0; i <= 1000; ++i) {
      const double t = i / 1000.0;
      const double r = 1.0 - t;
      const Vector2d px = r * r * r * curve.points[0] + 3.0 * r * r * t * curve.points[1] +
                          3.0 * r * t * t * curve.points[2] + t * t * t * curve.points[3];
      const Vector3d hit =
          back * Vector3d(2.0 * px.x() / kPictureWidth - 1.0, 1.0 - 2.0 * px.y() / kPictureHeight, 1.0);
      farthest = std::max(farthest, distance_to(path.flat.strokes, hit.head<2>() / hit.z()));
    }
    EXPECT_LE(farthest, path.flat.deviation_m) << "trial " << trial;
    EXPECT_GT(farthest, 0.0);
  }
}

TEST(ViewCut, LayerRulesOnAFoldedSheet) {
  for (const int layers : {1, 2, 3, 5, 8}) {
    const double gap = 0.02;
    const Scene s = scene(41, folded(layers, gap));
    View view = from_above(layers);
    const double middle = 0.5 / layers;
    const Polyline down = line_on_picture(view, {middle, 1.2, 0.0}, {middle, -0.2, 0.0});
    view.layers = LayerRule::kAll;
    const ViewPath all = lay(s, down, view);
    EXPECT_EQ(all.flat.strokes.size(), static_cast<std::size_t>(layers));
    for (const ViewLayer& layer : all.layers) EXPECT_NEAR(layer.length_m, 1.0, 0.05);
    view.layers = LayerRule::kNearest;
    const ViewPath nearest = lay(s, down, view);
    ASSERT_EQ(nearest.flat.strokes.size(), 1u);
    EXPECT_TRUE(nearest.layers[0].faces_camera);
    for (const Vector2d& p : nearest.flat.strokes[0].points) EXPECT_LT(p.x(), 1.0 / layers);
    if (layers < 2) continue;
    view.layers = LayerRule::kDepthRange;
    view.nearest_m = 3.0 + gap * 1.1;
    view.farthest_m = 3.0 + gap * 1.9;
    const ViewPath second = lay(s, down, view);
    ASSERT_EQ(second.flat.strokes.size(), 1u);
    EXPECT_FALSE(second.layers[0].faces_camera);
    for (const Vector2d& p : second.flat.strokes[0].points) {
      EXPECT_GT(p.x(), 1.0 / layers);
      EXPECT_LT(p.x(), 2.0 / layers);
    }
  }
}

TEST(ViewCut, OneChainRunsRoundTheFolds) {
  for (const int layers : {2, 3, 8}) {
    Scene s = scene(41, folded(layers, 0.01));
    View view = from_above(layers);
    view.layers = LayerRule::kAll;
    const Polyline across = line_on_picture(view, {-0.3, 0.52, 0.0}, {1.0 / layers + 0.3, 0.47, 0.0});
    const ViewPath path = lay(s, across, view);
    ASSERT_EQ(path.flat.strokes.size(), 1u) << layers;
    EXPECT_GE(path.layers[0].length_m, 1.0);
    const CutOutcome outcome = cut_on_picture(s, across, view);
    EXPECT_EQ(outcome.report.pieces, 2);
    EXPECT_EQ(outcome.report.layers.size(), 1u);
  }
}

TEST(ViewCut, NearestEndsAtTheFold) {
  Scene s = scene(41, folded(3, 0.05));
  const View view = from_above(3);
  const CutOutcome outcome = cut_on_picture(s, line_on_picture(view, {-0.2, 0.5, 0.0}, {0.6, 0.5, 0.0}), view);
  EXPECT_EQ(outcome.report.pieces, 1);  // from the border to the fold, where the layer turns away
  ASSERT_FALSE(outcome.report.layers.empty());
  EXPECT_NEAR(outcome.report.layers[0].length_m, 1.0 / 3.0, 0.02);
}

TEST(ViewCut, ACircleThroughAllLayersPunchesEach) {
  for (const int layers : {1, 3, 8}) {
    Scene s = scene(65, folded(layers, 0.01));
    View view = from_above(layers);
    view.layers = LayerRule::kAll;
    Circle circle;
    circle.centre = pixel(view, {0.5 / layers, 0.5, 0.0});
    circle.radius = 0.25 / layers * kPictureHeight / (2.0 * 3.0 * std::tan(0.35));
    const ViewPath path = lay(s, circle, view);
    ASSERT_EQ(path.flat.strokes.size(), static_cast<std::size_t>(layers));
    for (const Stroke& stroke : path.flat.strokes) EXPECT_TRUE(is_closed(stroke));
    const CutOutcome outcome = cut_on_picture(s, circle, view);
    EXPECT_EQ(outcome.report.pieces, 1 + layers);
    EXPECT_EQ(outcome.report.layers.size(), static_cast<std::size_t>(layers));
  }
}

TEST(ViewCut, OnePieceLeavesTheOthers) {
  // Two cut halves lie over each other.
  Scene s = scene(31, lay_flat);
  CutRequest split;
  split.curve = Polyline{{{0.5, -0.5}, {0.5, 1.5}}};
  ASSERT_TRUE(apply(s.mesh, plan(s.mesh, split).value()).ok());
  ASSERT_EQ(s.mesh.num_pieces(), 2);
  s.positions.resize(s.mesh.num_vertices());
  for (mesh::TriangleId t = 0; t < s.mesh.num_triangle_slots(); ++t) {
    if (!s.mesh.is_solid(t)) continue;
    const bool right = s.mesh.rest_position(s.mesh.vertices(t)[0]).x() +
                           s.mesh.rest_position(s.mesh.vertices(t)[1]).x() +
                           s.mesh.rest_position(s.mesh.vertices(t)[2]).x() >
                       1.5;
    for (const mesh::VertexId v : s.mesh.vertices(t)) {
      const Vector2d at = s.mesh.rest_position(v);
      s.positions.col(v) = right ? Vector3d(at.x() - 0.5, at.y(), -0.2) : Vector3d(at.x(), at.y(), 0.0);
    }
  }
  View view = view_from({0.25, 0.5, 3.0}, {0.25, 0.5, 0.0});
  const Polyline line = line_on_picture(view, {-0.2, 0.5, 0.0}, {0.7, 0.5, 0.0});
  view.layers = LayerRule::kAll;
  EXPECT_EQ(lay(s, line, view).flat.strokes.size(), 2u);
  view.layers = LayerRule::kPiece;
  const ViewPath seen = lay(s, line, view);  // the piece on top
  ASSERT_EQ(seen.flat.strokes.size(), 1u);
  for (const Vector2d& p : seen.flat.strokes[0].points) EXPECT_LE(p.x(), 0.5 + 1e-12);
  view.piece = 1 - seen.layers[0].piece;
  const ViewPath below = lay(s, line, view);
  ASSERT_EQ(below.flat.strokes.size(), 1u);
  for (const Vector2d& p : below.flat.strokes[0].points) EXPECT_GE(p.x(), 0.5 - 1e-12);
  view.piece = 2;
  const Result<ViewPath> unknown = project_onto_sheet(s.mesh, s.positions, line, view, 1e-3);
  ASSERT_FALSE(unknown.ok());
  EXPECT_EQ(unknown.error().reason, "PIECE_UNKNOWN");
}

TEST(ViewCut, ASheetSeenEdgeOnIsCutAlongTheSightLine) {
  // The camera lies in the sheet's plane: a line across its picture, a single line of pixels, is a cut right through.
  Scene s = scene(21, lay_flat);
  View view = view_from({0.5, -3.0, 0.0}, {0.5, 0.5, 0.0}, Vector3d::UnitZ());
  view.layers = LayerRule::kAll;
  const Polyline line = line_on_picture(view, {0.437, 0.0, 0.3}, {0.437, 0.0, -0.3});
  const CutOutcome outcome = cut_on_picture(s, line, view);
  EXPECT_EQ(outcome.report.pieces, 2);
  EXPECT_GT(outcome.report.view_deviation_m, 0.0);
  EXPECT_GE(outcome.report.deviation_m, outcome.report.view_deviation_m);
  // The sight line through (0.437, 0) from the eye.
  for (const double y : {0.1, 0.5, 0.9}) {
    const Vector2d on_line(0.5 + (0.437 - 0.5) * (y + 3.0) / 3.0, y);
    double least = 1.0;
    for (mesh::PointId p = 0; p < s.mesh.num_points(); ++p) {
      if ((s.mesh.locks_at_point(p) & mesh::kLockCut) != 0) {
        least = std::min(least, (s.mesh.point_position(p) - on_line).norm());
      }
    }
    EXPECT_LT(least, 0.05) << y;
  }
}

TEST(ViewCut, BehindTheCameraAndBesideThePicture) {
  Scene s = scene(11, lay_flat);
  // Looks away.
  const View away = view_from({0.5, 0.5, 3.0}, {0.5, 0.5, 6.0});
  const Polyline line{{{0.0, 300.0}, {800.0, 300.0}}};
  const ViewPath behind = lay(s, line, away);
  EXPECT_TRUE(behind.flat.strokes.empty());
  EXPECT_EQ(behind.behind, s.mesh.num_solid_triangles());
  // Stands in the middle of the sheet: what reaches behind is left out, the rest is cut.
  const View inside = view_from({0.5, 0.5, 0.1}, {0.5, 2.0, -0.2}, Vector3d::UnitZ());
  const ViewPath half = lay(s, line, inside);
  EXPECT_GT(half.behind, 0);
  EXPECT_LT(half.behind, s.mesh.num_solid_triangles());
  // Beside.
  const View other = view_from({9.5, 0.5, 3.0}, {9.5, 0.5, 0.0});
  EXPECT_TRUE(lay(s, line, other).flat.strokes.empty());
}

TEST(ViewCut, RandomViewsOfACrumpledSheetKeepEveryInvariant) {
  SeededRandom random(11);
  const auto uniform = [&](double low, double high) { return low + (high - low) * random.uniform(); };
  int applied = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const double a = uniform(2.0, 9.0), b = uniform(2.0, 9.0), c = uniform(0.05, 0.4), d = uniform(0.0, 6.0);
    Scene s = scene(14, [&](const Vector2d& at) {
      return Vector3d(at.x() + c * std::sin(a * at.y() + d), at.y() + c * std::sin(b * at.x()),
                      c * std::sin(a * at.x() + b * at.y()));
    });
    View view = view_from({uniform(-2, 3), uniform(-2, 3), uniform(-2, 3)}, {0.5, 0.5, 0.0}, {0.1, 0.2, 1.0});
    view.layers = trial % 3 == 0 ? LayerRule::kAll : LayerRule::kNearest;
    CubicBezier curve;
    for (int i = 0; i < 4; ++i) curve.points.emplace_back(uniform(150, 650), uniform(100, 500));
    if (trial % 5 == 0) curve.points[3] = curve.points[0];
    const CutOutcome outcome = cut_on_picture(s, curve, view);
    if (outcome.status == CutStatus::kApplied) ++applied;
  }
  EXPECT_GT(applied, 40);
}

TEST(ViewCut, AStripOnAPictureKeepsItsToleranceWhereverTheSheetBends) {
  SeededRandom random(11);
  for (int trial = 0; trial < 40; ++trial) {
    SCOPED_TRACE(trial);
    const double depth = random.uniform(0.0, 0.3), bends = random.uniform(1.0, 9.0);
    Scene s = scene(15, [&](const Vector2d& at) {
      return Vector3d(at.x(), at.y(), depth * std::sin(bends * (at.x() + 0.3 * at.y())));
    });
    CutRequest request;
    CubicBezier curve;
    for (int i = 0; i < 4; ++i) curve.points.emplace_back(random.uniform(200, 600), random.uniform(100, 500));
    request.curve = curve;
    request.view = view_from({random.uniform(-1, 2), random.uniform(-1, 2), 2.5}, {0.5, 0.5, 0.0});
    request.view->layers = trial % 2 == 0 ? LayerRule::kAll : LayerRule::kNearest;
    request.positions = &s.positions;
    request.options.width_m = random.uniform(0.005, 0.05);
    const Result<CutPlan> planned = plan(s.mesh, request);
    ASSERT_TRUE(planned.ok()) << planned.error().message;
    EXPECT_LE(planned->curve_deviation_m, 0.02 / 14.0);
    const Result<CutOutcome> outcome = apply(s.mesh, *planned);
    ASSERT_TRUE(outcome.ok()) << outcome.error().message;
    EXPECT_GT(outcome->report.removed_area_m2, 0.0);
    EXPECT_EQ(s.mesh.find_violation().value_or(""), "");
  }
}

TEST(ViewCut, RefusesWhatIsNoView) {
  const View good = view_from({0.5, 0.5, 3.0}, {0.5, 0.5, 0.0});
  EXPECT_TRUE(validate(good).ok());
  const auto reason = [&](const std::function<void(View&)>& spoil) {
    View view = good;
    spoil(view);
    const Status status = validate(view);
    return status.ok() ? std::string("accepted") : status.error().reason + " " + status.error().field;
  };
  EXPECT_EQ(reason([](View& v) { v.view(0, 3) = NAN; }), "VIEW_NOT_FINITE cut.view.view");
  EXPECT_EQ(reason([](View& v) { v.projection(0, 0) = INFINITY; }), "VIEW_NOT_FINITE cut.view.projection");
  EXPECT_EQ(reason([](View& v) { v.view(0, 0) *= 2.0; }), "VIEW_NOT_RIGID cut.view.view");
  EXPECT_EQ(reason([](View& v) { v.view.row(0) *= -1.0; }), "VIEW_NOT_RIGID cut.view.view");
  EXPECT_EQ(reason([](View& v) { v.view(3, 3) = 0.0; }), "VIEW_NOT_RIGID cut.view.view");
  EXPECT_EQ(reason([](View& v) { v.projection.row(1).setZero(); }), "VIEW_SINGULAR cut.view.projection");
  EXPECT_EQ(reason([](View& v) { v.width_px = 0.0; }), "VIEWPORT_OUT_OF_RANGE cut.view.width_px");
  EXPECT_EQ(reason([](View& v) { v.height_px = 65537.0; }), "VIEWPORT_OUT_OF_RANGE cut.view.height_px");
  EXPECT_EQ(reason([](View& v) { v.height_px = 65536.0; }), "accepted");
  EXPECT_EQ(reason([](View& v) {
              v.layers = LayerRule::kDepthRange;
              v.nearest_m = 2.0;
              v.farthest_m = 1.0;
            }),
            "DEPTH_RANGE cut.view.nearest_m");
  // Layers that do not go by depth are no exception.
  EXPECT_EQ(reason([](View& v) { v.nearest_m = NAN; }), "VIEW_NOT_FINITE cut.view.nearest_m");
  EXPECT_EQ(reason([](View& v) { v.farthest_m = INFINITY; }), "VIEW_NOT_FINITE cut.view.farthest_m");
  EXPECT_EQ(reason([](View& v) { v.piece = -2; }), "PIECE_UNKNOWN cut.view.piece");
}

}  // namespace
}  // namespace kerf::cut
