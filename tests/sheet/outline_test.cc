#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/core/fem/element/state.h"
#include "server/core/sheet/sheet.h"
#include "tests/sheet/calls.h"
#include "tests/support/scenes.h"

namespace kerf::sheet {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;

cut::Polyline rectangle(const Vector2d& low, const Vector2d& high) {
  return {{low, {high.x(), low.y()}, high, {low.x(), high.y()}, low}};
}

scene::OutlineSource square_with_hole() {
  scene::OutlineSource outline;
  outline.boundary = rectangle({0, 0}, {1, 1});
  outline.holes = {cut::Circle{{0.5, 0.5}, 0.2}};
  outline.edge_length = 0.1;
  return outline;
}

scene::SheetConfig config_of(const scene::OutlineSource& outline) {
  scene::SheetConfig config = scenes::hanging(4);
  config.mesh = outline;
  config.pins.clear();
  return config;
}

double area_of(const Sheet& sheet) {
  double area = 0.0;
  for (mesh::TriangleId t = 0; t < sheet.mesh().num_triangle_slots(); ++t) {
    if (sheet.mesh().is_solid(t)) area += sheet.mesh().area(t);
  }
  return area;
}

// "REASON field" of the refusal, or "accepted". Of a sheet that need not move.
std::string refusal(const std::function<void(scene::OutlineSource&)>& spoil,
                    std::int32_t max_vertices = scene::kMaxVertices) {
  scene::OutlineSource outline = square_with_hole();
  spoil(outline);
  scene::SheetConfig config = config_of(outline);
  config.max_vertices = max_vertices;
  config.analysis = scene::StaticAnalysis{};
  const Result<Sheet> created = Sheet::create(config);
  if (created.ok()) return "accepted";
  EXPECT_FALSE(created.error().message.empty());
  EXPECT_EQ(created.error().message.find("cut.curve"), std::string::npos) << created.error().message;
  EXPECT_EQ(created.error().code,
            created.error().reason == "OUTLINE_TOO_FINE" || created.error().reason == "OUTLINE_CURVES"
                ? ErrorCode::kResourceExhausted
                : ErrorCode::kInvalidArgument);
  return created.error().reason + " " + created.error().field;
}

int vertices_at(const Sheet& sheet, const Vector2d& at) {
  int count = 0;
  for (mesh::VertexId v = 0; v < sheet.mesh().num_vertices(); ++v) {
    if ((sheet.mesh().rest_position(v) - at).norm() < 1e-12) ++count;
  }
  return count;
}

TEST(SheetOutline, EveryKindOfCurveBoundsASheet) {
  const double full = 0.25 * pi;
  scene::OutlineSource outline;
  outline.edge_length = 0.02;
  const auto area_within = [&](cut::Curve boundary) {
    outline.boundary = std::move(boundary);
    return area_of(make(config_of(outline)));
  };
  EXPECT_NEAR(area_within(cut::Circle{{0.3, 0.2}, 0.5}), full, 3e-4);
  EXPECT_NEAR(area_within(cut::Ellipse{{0.3, 0.2}, {1.0, 0.25}, 0.4}), full, 3e-4);
  const double k = 4.0 / 3.0 * (std::numbers::sqrt2 - 1.0) * 0.5;  // the usual four Bezier pieces of a circle
  EXPECT_NEAR(area_within(cut::CubicBezier{{{0.5, 0},
                                            {0.5, k},
                                            {k, 0.5},
                                            {0, 0.5},
                                            {-k, 0.5},
                                            {-0.5, k},
                                            {-0.5, 0},
                                            {-0.5, -k},
                                            {-k, -0.5},
                                            {0, -0.5},
                                            {k, -0.5},
                                            {0.5, -k},
                                            {0.5, 0}}}),
              full, 5e-4);
  const cut::ArcTo back{{0.5, 0.5}, 0.0, false, true, {-0.5, 0.0}};
  const cut::ArcTo forth{{0.5, 0.5}, 0.0, false, true, {0.5, 0.0}};
  EXPECT_NEAR(area_within(cut::Path{{{{0.5, 0.0}, {back, forth}, false}}}), full, 3e-4);
  EXPECT_NEAR(
      area_within(cut::Path{{{{0, 0}, {cut::LineTo{{1, 0}}, cut::LineTo{{1, 0.7}}, cut::LineTo{{0, 0.7}}}, true}}}),
      0.7, 1e-11);
  EXPECT_NEAR(area_within(rectangle({-1, -1}, {1, 0})), 2.0, 1e-11);
}

TEST(SheetOutline, HolesOfManyLinesAndEndsOfPiecesAreVertices) {
  scene::OutlineSource outline = square_with_hole();
  // A quarter plate: the arc ends where the lines begin.
  outline.boundary = cut::Path{{{{0.3, 0.0},
                                 {cut::LineTo{{1, 0}}, cut::LineTo{{1, 1}}, cut::LineTo{{0, 1}}, cut::LineTo{{0, 0.3}},
                                  cut::ArcTo{{0.3, 0.3}, 0.0, false, false, {0.3, 0.0}}},
                                 false}}};
  cut::Path slots;
  for (const double x : {0.5, 0.7}) {
    slots.subpaths.push_back({{x, 0.5}, {cut::LineTo{{x + 0.1, 0.5}}, cut::LineTo{{x + 0.05, 0.6}}}, true});
  }
  outline.holes = {slots, cut::Ellipse{{0.8, 0.8}, {0.1, 0.05}, 0.3}};
  const Sheet sheet = make(config_of(outline));
  EXPECT_EQ(sheet.mesh().num_boundary_loops(), 4);
  EXPECT_EQ(sheet.mesh().num_pieces(), 1);
  for (const Vector2d& corner : {Vector2d(0.3, 0.0), Vector2d(1, 1), Vector2d(0, 0.3), Vector2d(0.5, 0.5),
                                 Vector2d(0.8, 0.5), Vector2d(0.75, 0.6)}) {
    EXPECT_EQ(vertices_at(sheet, corner), 1) << corner.transpose();
  }
  int num_on_arc = 0;
  for (mesh::VertexId v = 0; v < sheet.mesh().num_vertices(); ++v) {
    if (std::abs(sheet.mesh().rest_position(v).norm() - 0.3) < 1e-12) ++num_on_arc;
  }
  EXPECT_GE(num_on_arc, 5);
  EXPECT_NEAR(area_of(sheet), 1.0 - 0.0225 * pi - 0.01 - 0.005 * pi, 2e-3);
}

TEST(SheetOutline, LinesOfTheBorderNest) {
  const auto square = [](double x, double y, double side) {
    return cut::Subpath{
        {x, y}, {cut::LineTo{{x + side, y}}, cut::LineTo{{x + side, y + side}}, cut::LineTo{{x, y + side}}}, true};
  };
  scene::OutlineSource outline;
  // A panel with a hole, an island in the hole, and a second panel; in any order.
  outline.boundary = cut::Path{{square(0.2, 0.2, 0.6), square(2, 0, 1), square(0, 0, 1), square(0.4, 0.4, 0.2)}};
  outline.edge_length = 0.1;
  const Result<Sheet> nested = Sheet::create(config_of(outline));
  ASSERT_TRUE(nested.ok()) << nested.error().message;
  EXPECT_NEAR(area_of(*nested), 1.0 - 0.36 + 0.04 + 1.0, 1e-9);
  EXPECT_EQ(nested->mesh().num_pieces(), 3);
  // A hole by itself goes where the sheet is, and nowhere else.
  outline.holes = {cut::Circle{{2.5, 0.5}, 0.2}};
  const Result<Sheet> with_hole = Sheet::create(config_of(outline));
  ASSERT_TRUE(with_hole.ok()) << with_hole.error().message;
  EXPECT_LT(area_of(*with_hole), 1.68 - 0.12);
  for (const Vector2d& wrong : {Vector2d(0.3, 0.3), Vector2d(1.5, 0.5)}) {
    outline.holes = {cut::Circle{wrong, 0.05}};
    const Result<Sheet> refused = Sheet::create(config_of(outline));
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().reason, "OUTLINE_NESTING");
  }
}

TEST(SheetOutline, SizesAtPointsAndAlongCurves) {
  scene::OutlineSource outline = square_with_hole();
  const auto least_edge_near = [&](const Vector2d& at) {
    const Sheet sheet = make(config_of(outline));
    double least = 1.0;
    for (mesh::TriangleId t = 0; t < sheet.mesh().num_triangle_slots(); ++t) {
      for (int k = 0; k < 3 && sheet.mesh().is_solid(t); ++k) {
        const Vector2d p = sheet.mesh().rest_position(sheet.mesh().vertices(t)[k]);
        const Vector2d q = sheet.mesh().rest_position(sheet.mesh().vertices(t)[mesh::next_corner(k)]);
        if ((p - at).norm() < 0.02) least = std::min(least, (p - q).norm());
      }
    }
    return least;
  };
  EXPECT_GT(least_edge_near({0.7, 0.5}), 0.05);
  outline.sizes = {{Vector2d(0.7, 0.5), 0.004, 0.25}};
  EXPECT_NEAR(least_edge_near({0.7, 0.5}), 0.004, 0.0015);
  EXPECT_GT(least_edge_near({0.0, 0.0}), 0.05);
  outline.sizes = {{cut::Circle{{0.5, 0.5}, 0.2}, 0.01, 0.25}};
  for (const Vector2d& at : {Vector2d(0.7, 0.5), Vector2d(0.3, 0.5), Vector2d(0.5, 0.7)}) {
    EXPECT_NEAR(least_edge_near(at), 0.01, 0.004);
  }
  outline.sizes = {{cut::Polyline{{{0.1, 0.1}, {0.4, 0.1}}}, 0.01, 0.5}};  // of no part of the outline
  EXPECT_NEAR(least_edge_near({0.2, 0.1}), 0.01, 0.004);
}

TEST(SheetOutline, LongestEdgeIsAThirtySecondOfTheLargerSide) {
  scene::OutlineSource outline;
  outline.boundary = rectangle({2, 0}, {10, 1});
  const Sheet sheet = make(config_of(outline));
  EXPECT_NEAR(sheet.mesh().num_vertices(), 8.0 / (0.5 * std::numbers::sqrt3 * 0.0625), 40.0);
}

TEST(SheetOutline, IsPlacedPinnedCutAndRunAsAnyOther) {
  scene::OutlineSource outline = square_with_hole();
  scene::SheetConfig config = config_of(outline);
  config.pins = {scene::RegionEdge::kTop};
  config.placement.origin = {1.0, 2.0, 3.0};
  Sheet sheet = make(config);
  EXPECT_EQ(sheet.state_hash(), make(config).state_hash());
  for (mesh::VertexId v = 0; v < sheet.mesh().num_vertices(); ++v) {
    const Vector2d at = sheet.mesh().rest_position(v);
    EXPECT_LT((sheet.state().x.col(v) - Eigen::Vector3d(1.0 + at.x(), 2.0, 3.0 + at.y())).norm(), 1e-12);
  }
  const std::int32_t before = sheet.mesh().num_vertices();
  EXPECT_EQ(reason(apply(sheet, scenes::line_cut({-0.1, 0.3}, {1.1, 0.3}))), "done");
  EXPECT_EQ(sheet.mesh().num_pieces(), 2);
  EXPECT_GT(sheet.mesh().num_vertices(), before);
  run(sheet, 5);
  EXPECT_TRUE(sheet.state().x.allFinite());
}

TEST(SheetOutline, RefusesWhatIsNoOutlineWithItsField) {
  EXPECT_EQ(refusal([](scene::OutlineSource&) {}), "accepted");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              o.boundary = cut::Polyline{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
            }),
            "OUTLINE_OPEN outline.boundary");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              o.boundary = cut::Polyline{{{0, 0}, {1, kNan}, {0, 0}}};
            }),
            "CURVE_NOT_FINITE outline.boundary.polyline.points[1].y");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              o.boundary = cut::Polyline{{{0, 0}, {1, 0.1}, {1, 0}, {0, 0.1}, {0, 0}}};
            }),
            "OUTLINE_CROSSES outline.boundary");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              o.boundary = cut::Polyline{{{0, 0}, {1, 1}, {0, 0}}};
            }),
            "OUTLINE_DEGENERATE outline.boundary");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              const cut::Subpath triangle{{0, 0}, {cut::LineTo{{1, 0}}, cut::LineTo{{0, 1}}}, true};
              o.boundary = cut::Path{{triangle, triangle}};
            }),
            "OUTLINE_CROSSES outline.boundary");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              o.boundary = cut::Circle{{9999, 0}, 2};
            }),
            "OUTLINE_OUT_OF_RANGE outline.boundary");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              o.holes[0] = cut::Circle{{0.5, 0.5}, 0.0};
            }),
            "RADIUS_NOT_POSITIVE outline.holes[0].circle.radius_m");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              o.holes.push_back(cut::Circle{{0.5, 0.7}, 0.1});
            }),
            "OUTLINE_CROSSES outline.holes[1]");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              o.holes.push_back(cut::Circle{{0.1, 0.1}, 0.1});
            }),
            "OUTLINE_CROSSES outline.holes[1]");  // touches two sides
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              o.holes.push_back(cut::Circle{{0.5, 0.5}, 0.1});
            }),
            "OUTLINE_NESTING outline.holes[1]");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              o.holes.push_back(cut::Circle{{1.5, 0.5}, 0.1});
            }),
            "OUTLINE_NESTING outline.holes[1]");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              o.holes.push_back(cut::Polyline{{{0.1, 0.1}, {0.2, 0.1}, {0.2, 0.2}}});
            }),
            "OUTLINE_OPEN outline.holes[1]");
}

TEST(SheetOutline, EdgesTooShortForDoublePrecisionAreRefusedWithTheConditionNumber) {
  scene::OutlineSource outline = square_with_hole();
  outline.sizes = {{Vector2d(0.5, 0.1), 1e-9, 0.25}};
  const Result<Sheet> refused = Sheet::create(config_of(outline));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(refused.error().reason, "SHEET_TOO_STIFF");
  EXPECT_NE(refused.error().message.find("condition number"), std::string::npos) << refused.error().message;
  // Stiffness over mass grows as the inverse square of the length.
  outline.sizes = {{Vector2d(0.5, 0.1), 1e-6, 0.25}};
  const Result<Sheet> bounded = Sheet::create(config_of(outline));
  ASSERT_TRUE(bounded.ok()) << refused.error().message << bounded.error().message;
  EXPECT_NE(bounded->integrator_description().find("class B"), std::string::npos) << bounded->integrator_description();
  const Result<Sheet> accurate = Sheet::create(config_of(square_with_hole()));
  ASSERT_TRUE(accurate.ok());
  EXPECT_NE(accurate->integrator_description().find("class A"), std::string::npos);
}

TEST(SheetOutline, NumbersAreCheckedAtTheirLimits) {
  const auto with_size = [](double length, double growth) {
    return refusal([=](scene::OutlineSource& o) { o.sizes = {{Vector2d(0.5, 0.1), length, growth}}; });
  };
  EXPECT_EQ(with_size(0.05, 0.25), "accepted");
  EXPECT_EQ(with_size(1e-9, 0.25), "accepted");
  EXPECT_EQ(with_size(0.9e-9, 0.25), "OUT_OF_RANGE outline.sizes[0].edge_length_m");
  EXPECT_EQ(with_size(0.0, 0.25), "OUT_OF_RANGE outline.sizes[0].edge_length_m");
  EXPECT_EQ(with_size(kNan, 0.25), "NOT_FINITE outline.sizes[0].edge_length_m");
  EXPECT_EQ(with_size(1e4, 0.25), "accepted");
  EXPECT_EQ(with_size(1.1e4, 0.25), "OUT_OF_RANGE outline.sizes[0].edge_length_m");
  EXPECT_EQ(with_size(0.05, 0.01), "accepted");
  EXPECT_EQ(with_size(0.05, 0.009), "OUT_OF_RANGE outline.sizes[0].growth");
  EXPECT_EQ(with_size(0.05, 10.0), "accepted");
  EXPECT_EQ(with_size(0.05, 10.1), "OUT_OF_RANGE outline.sizes[0].growth");
  // Finer than a billionth of the sheet.
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              o.boundary = rectangle({0, 0}, {2, 1});
              o.sizes = {{Vector2d(0.5, 0.1), 1e-9, 0.25}};
            }),
            "OUTLINE_EDGE_LENGTH outline.sizes[0].edge_length_m");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              o.sizes = {{Vector2d(0.5, 1.1e4), 0.1, 0.25}};
            }),
            "OUT_OF_RANGE outline.sizes[0].point.y");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              o.sizes = {{cut::Polyline{{{0, 0}}}, 0.1, 0.25}};
            }),
            "CURVE_TOO_SHORT outline.sizes[0].curve.polyline.points");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) { o.edge_length = -0.1; }), "OUT_OF_RANGE outline.edge_length_m");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) { o.edge_length = 1.1e4; }), "OUT_OF_RANGE outline.edge_length_m");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) { o.min_angle_deg = 5.0; }), "accepted");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) { o.min_angle_deg = 4.9; }), "OUT_OF_RANGE outline.min_angle_deg");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) { o.min_angle_deg = 28.0; }), "accepted");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) { o.min_angle_deg = 28.1; }), "OUT_OF_RANGE outline.min_angle_deg");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              o.sizes.resize(scene::kMaxOutlineSizes, {Vector2d(0, 0), 0.1, 0.25});
            }),
            "accepted");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) {
              o.sizes.resize(scene::kMaxOutlineSizes + 1, {Vector2d(0, 0), 0.1, 0.25});
            }),
            "TOO_MANY outline.sizes");
}

TEST(SheetOutline, HolesAndTheirChordsAreLimited) {
  const auto with_holes = [](std::size_t count, bool is_round) {
    return refusal([=](scene::OutlineSource& o) {
      o.holes.clear();
      for (std::size_t i = 0; i < count; ++i) {
        const Vector2d at(0.03 * static_cast<double>(i % 32) + 0.02, 0.028 * static_cast<double>(i / 32) + 0.02);
        const Vector2d half(0.005, 0.005);
        if (is_round) {
          o.holes.emplace_back(cut::Circle{at, 0.005});
        } else {
          o.holes.emplace_back(rectangle(at - half, at + half));
        }
      }
    });
  };
  EXPECT_EQ(with_holes(scene::kMaxOutlineHoles, false), "accepted");
  EXPECT_EQ(with_holes(scene::kMaxOutlineHoles + 1, false), "TOO_MANY outline.holes");
  EXPECT_EQ(with_holes(700, true), "accepted");
  EXPECT_EQ(with_holes(scene::kMaxOutlineHoles, true).substr(0, 28), "OUTLINE_CURVES outline.holes");
}

TEST(SheetOutline, NoMoreVerticesThanTheSceneAllows) {
  const std::int32_t needed = make(config_of(square_with_hole())).mesh().num_vertices();
  EXPECT_EQ(refusal([](scene::OutlineSource&) {}, needed), "accepted");
  EXPECT_EQ(refusal([](scene::OutlineSource&) {}, needed - 1), "OUTLINE_TOO_FINE outline.edge_length_m");
  EXPECT_EQ(refusal([](scene::OutlineSource& o) { o.edge_length = 1e-8; }), "OUTLINE_TOO_FINE outline.edge_length_m");
}

}  // namespace
}  // namespace kerf::sheet
