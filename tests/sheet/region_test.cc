// Regions along lines, curves and whole borders, and those that name nothing.
#include "server/core/scene/region.h"

#include <algorithm>
#include <cmath>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/model.h"
#include "server/core/scene/sheet_materials.h"
#include "tests/sheet/calls.h"

namespace kerf::sheet {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using scenes::flat;
using Vertices = std::vector<mesh::VertexId>;

// A ring of radii 0.5 and 0.2 about (0, 0).
scene::SheetConfig ring() {
  scene::SheetConfig config = flat(4);
  scene::OutlineSource outline;
  outline.boundary = cut::Circle{{0.0, 0.0}, 0.5};
  outline.holes = {cut::Circle{{0.0, 0.0}, 0.2}};
  outline.edge_length = 0.05;
  config.mesh = outline;
  return config;
}

Vertices found(const Sheet& sheet, const scene::Region& region) {
  return scene::find_vertices(sheet.mesh(), scene::place(region, sheet.components(), "").value(), "").value();
}

// Vertices at which `holds` of the material position.
template <typename Predicate>
Vertices where(const Sheet& sheet, Predicate holds) {
  Vertices vertices;
  for (mesh::VertexId v = 0; v < sheet.mesh().num_vertices(); ++v) {
    if (sheet.mesh().has_material(v) && holds(sheet.mesh().rest_position(v))) vertices.push_back(v);
  }
  return vertices;
}

TEST(Regions, OfLinesNearestVerticesAndTheWholeSheet) {
  const mesh::TriangleMesh mesh = make(flat(5)).mesh();
  const auto found = [&](const scene::Region& region) {
    return scene::find_vertices(mesh, {region.shape}, "pins[0]").value();
  };
  EXPECT_EQ(found(scene::MaterialLine{{0.0, 0.5}, {0.5, 0.5}}), (Vertices{10, 11, 12}));
  EXPECT_EQ(found(scene::MaterialLine{{0.0, 0.0}, {1.0, 1.0}}), (Vertices{0, 6, 12, 18, 24}));
  EXPECT_EQ(found(scene::MaterialLine{{0.5, 0.5}, {0.5, 0.5}, 0.26}), (Vertices{7, 11, 12, 13, 17}));  // a disc
  EXPECT_EQ(found(scene::NearestVertex{{0.3, 0.3}}), (Vertices{6}));
  EXPECT_EQ(found(scene::NearestVertex{{0.125, 0.0}}), (Vertices{0}));  // of two
  EXPECT_EQ(found(scene::WholeSheet{}).size(), 25U);
}

TEST(Regions, TellTheTwoLipsOfACutApart) {
  Sheet sheet = make(flat(9));
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.25, 0.5}, {0.75, 0.5})).ok());
  scene::MaterialLine line{{0.25, 0.5}, {0.75, 0.5}};
  const auto found = [&] { return scene::find_vertices(sheet.mesh(), {line}, "").value(); };
  const std::size_t both = found().size();
  line.side = scene::MaterialLine::Side::kLeft;
  const std::vector<mesh::VertexId> upper = found();
  line.side = scene::MaterialLine::Side::kRight;
  const std::vector<mesh::VertexId> lower = found();
  EXPECT_EQ(upper.size() + lower.size(), both);
  EXPECT_GE(std::min(upper.size(), lower.size()), 3U);
  const auto rise_around = [&](mesh::VertexId v) {
    std::vector<mesh::TriangleId> fan;
    sheet.mesh().triangles_around(v, fan);
    double sum = 0.0;
    for (const mesh::TriangleId t : fan) {
      for (const mesh::VertexId w : sheet.mesh().vertices(t)) sum += sheet.mesh().rest_position(w).y() - 0.5;
    }
    return sum;
  };
  // Tips belong to both sides; every other vertex has its material on one.
  for (const mesh::VertexId v : upper) EXPECT_GT(rise_around(v), -1e-9);
  for (const mesh::VertexId v : lower) EXPECT_LT(rise_around(v), 1e-9);
}

TEST(CurveRegions, NameRoundBordersAndWhatIsWithinReach) {
  const Sheet sheet = make(ring());
  const auto near = [](double radius, double within) {
    return [=](const Vector2d& X) { return std::abs(X.norm() - radius) <= within; };
  };
  const Vertices outer = where(sheet, near(0.5, 1e-6));
  EXPECT_GE(outer.size(), 60U);
  EXPECT_EQ(found(sheet, scene::MaterialCurve{cut::Circle{{0.0, 0.0}, 0.5}}), outer);
  EXPECT_EQ(found(sheet, scene::MaterialCurve{cut::Circle{{0.0, 0.0}, 0.2}}), where(sheet, near(0.2, 1e-6)));
  // Flattened to within a hundredth of the reach: neither more nor less than that off.
  const Vertices some = found(sheet, scene::MaterialCurve{cut::Circle{{0.0, 0.0}, 0.35}, 0.05});
  const Vertices least = where(sheet, near(0.35, 0.99 * 0.05));
  const Vertices most = where(sheet, near(0.35, 1.01 * 0.05));
  EXPECT_TRUE(std::includes(some.begin(), some.end(), least.begin(), least.end()));
  EXPECT_TRUE(std::includes(most.begin(), most.end(), some.begin(), some.end()));
  EXPECT_LT(some.size(), static_cast<std::size_t>(sheet.mesh().num_vertices()));
  EXPECT_TRUE(found(sheet, scene::MaterialCurve{cut::Circle{{3.0, 0.0}, 0.2}}).empty());
}

TEST(CurveRegions, AreTheSameWhateverTheKindOfTheCurve) {
  const Sheet sheet = make(flat(9));
  const Vertices diagonal = found(sheet, scene::MaterialLine{{0.0, 0.0}, {1.0, 1.0}});
  ASSERT_EQ(diagonal.size(), 9U);
  cut::Subpath subpath{{0.0, 0.0}, {cut::LineTo{{1.0, 1.0}}}, false};
  for (const cut::Curve& curve : {cut::Curve(cut::Polyline{{{0.0, 0.0}, {0.3, 0.3}, {1.0, 1.0}}}),
                                  cut::Curve(cut::CubicBezier{{{0.0, 0.0}, {0.3, 0.3}, {0.6, 0.6}, {1.0, 1.0}}}),
                                  cut::Curve(cut::Path{{subpath}})}) {
    EXPECT_EQ(found(sheet, scene::MaterialCurve{curve}), diagonal);
  }
  const cut::Ellipse ellipse{{0.5, 0.5}, {0.25, 0.25}, 0.3};
  EXPECT_EQ(found(sheet, scene::MaterialCurve{ellipse, 0.02}),
            found(sheet, scene::MaterialCurve{cut::Circle{{0.5, 0.5}, 0.25}, 0.02}));
}

TEST(CurveRegions, TellTheLipsOfACurvedCutApart) {
  Sheet sheet = make(flat(17));
  const cut::Circle punch{{0.5, 0.5}, 0.23};
  // Three quarters around, from the lower right over the left, to the upper right.
  cut::Subpath arc{{0.5 + 0.23 * std::sqrt(0.5), 0.5 - 0.23 * std::sqrt(0.5)}, {}, false};
  arc.segments.push_back(
      cut::ArcTo{{0.23, 0.23}, 0.0, true, false, {0.5 + 0.23 * std::sqrt(0.5), 0.5 + 0.23 * std::sqrt(0.5)}});
  scene::Cut slit;
  slit.curve = cut::Path{{arc}};
  ASSERT_TRUE(apply(sheet, slit).ok());
  const auto side = [&](scene::MaterialLine::Side which) {
    return found(sheet, scene::MaterialCurve{slit.curve, 0.0, which});
  };
  const Vertices both = side(scene::MaterialLine::Side::kBoth);
  const Vertices left = side(scene::MaterialLine::Side::kLeft);  // clockwise: outside
  const Vertices right = side(scene::MaterialLine::Side::kRight);
  EXPECT_EQ(left.size() + right.size(), both.size());
  EXPECT_GE(left.size(), 12U);
  EXPECT_GE(right.size(), 12U);
  const auto outwardness = [&](mesh::VertexId v) {
    std::vector<mesh::TriangleId> fan;
    sheet.mesh().triangles_around(v, fan);
    double sum = 0.0;
    for (const mesh::TriangleId t : fan) {
      for (const mesh::VertexId w : sheet.mesh().vertices(t)) {
        sum += (sheet.mesh().rest_position(w) - punch.centre).norm() -
               (sheet.mesh().rest_position(v) - punch.centre).norm();
      }
    }
    return sum;
  };
  const auto is_tip = [&](mesh::VertexId v) {
    const Vector2d X = sheet.mesh().rest_position(v);
    return (X - arc.start).norm() < 1e-6 || (X - std::get<cut::ArcTo>(arc.segments[0]).end).norm() < 1e-6;
  };
  for (const mesh::VertexId v : left) EXPECT_TRUE(is_tip(v) || outwardness(v) > 0.0) << v;
  for (const mesh::VertexId v : right) EXPECT_TRUE(is_tip(v) || outwardness(v) < 0.0) << v;
}

TEST(CurveRegions, TellSidesAtSharpCorners) {
  Sheet sheet = make(flat(17));
  scene::Cut notch;  // a sharp V that opens upwards
  notch.curve = cut::Polyline{{{0.4, 0.8}, {0.5, 0.3}, {0.6, 0.8}}};
  ASSERT_TRUE(apply(sheet, notch).ok());
  const auto at_corner = [&](scene::MaterialLine::Side side) {
    int count = 0;
    for (const mesh::VertexId v : found(sheet, scene::MaterialCurve{notch.curve, 0.0, side})) {
      count += (sheet.mesh().rest_position(v) - Vector2d(0.5, 0.3)).norm() < 1e-6 ? 1 : 0;
    }
    return count;
  };
  EXPECT_EQ(at_corner(scene::MaterialLine::Side::kLeft), 1);
  EXPECT_EQ(at_corner(scene::MaterialLine::Side::kRight), 1);
}

TEST(CurveRegions, HaveTheTrianglesOnTheirSide) {
  scene::SheetConfig config = ring();
  fem::Material stiff = config.material;
  stiff.youngs_modulus_1 *= 2.0;
  // The inside of a circle: its left, within its radius.
  const scene::MaterialCurve disc{cut::Circle{{0.0, 0.0}, 0.35}, 0.35, scene::MaterialLine::Side::kLeft};
  config.materials = {{disc, stiff}};
  const Sheet sheet = make(config);
  const Vector2d zero(0.0, 0.0);
  double area = 0.0;
  const std::vector<mesh::TriangleId> inside = scene::find_triangles(sheet.mesh(), {disc}, "").value();
  for (const mesh::TriangleId t : inside) {
    const auto& corner = sheet.mesh().vertices(t);
    Vector2d centroid = zero;
    for (const mesh::VertexId v : corner) centroid += sheet.mesh().rest_position(v) / 3.0;
    EXPECT_LT(centroid.norm(), 0.35);
    area += scene::rest_area(sheet.mesh(), t);
  }
  const double exact = 3.14159265 * (0.35 * 0.35 - 0.2 * 0.2);
  EXPECT_NEAR(area, exact, 0.03 * exact);
  EXPECT_EQ(sheet.model().materials().size(), 2U);
  config.materials = {{scene::NearestBorder{{0.5, 0.0}}, stiff}};
  EXPECT_EQ(refused(config), "REGION_WITHOUT_TRIANGLES materials[0].region");
}

TEST(BorderRegions, AreAllAroundTheNearestHoleOrTheOutside) {
  const Sheet sheet = make(ring());
  const Vertices outer = where(sheet, [](const Vector2d& X) { return X.norm() > 0.5 - 1e-6; });
  const Vertices inner = where(sheet, [](const Vector2d& X) { return X.norm() < 0.2 + 1e-6; });
  EXPECT_EQ(found(sheet, scene::NearestBorder{{0.5, 0.0}}), outer);
  EXPECT_EQ(found(sheet, scene::NearestBorder{{-7.0, 3.0}}), outer);
  EXPECT_EQ(found(sheet, scene::NearestBorder{{0.0, 0.36}}), outer);
  EXPECT_EQ(found(sheet, scene::NearestBorder{{0.0, 0.34}}), inner);
  EXPECT_EQ(found(sheet, scene::NearestBorder{{0.0, 0.0}}), inner);
}

TEST(BorderRegions, FollowCutsAndUndos) {
  scene::SheetConfig config = flat(9);
  config.constraints = {hold(scene::NearestBorder{{0.5, 0.5}})};
  Sheet sheet = make(config);
  EXPECT_EQ(sheet.loads().pins.size(), 32U) << "no hole yet: the border of the square";
  // Lips are no border, but the two vertices that a cut makes of one on the border are on it.
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.3, -0.1}, {0.3, 0.4})).ok());
  const auto on_square = [](const Vector2d& X) { return std::min({X.x(), X.y(), 1.0 - X.x(), 1.0 - X.y()}) < 1e-9; };
  EXPECT_EQ(sheet.loads().pins.size(), where(sheet, on_square).size());
  scene::Cut punch;
  punch.curve = cut::Circle{{0.6, 0.6}, 0.05};
  punch.options.width_m = 0.11;
  ASSERT_TRUE(apply(sheet, punch).ok());
  const Vertices rim =
      where(sheet, [](const Vector2d& X) { return std::abs((X - Vector2d(0.6, 0.6)).norm() - 0.105) < 0.005; });
  ASSERT_EQ(sheet.loads().pins.size(), rim.size());
  for (std::size_t i = 0; i < rim.size(); ++i) EXPECT_EQ(sheet.loads().pins[i].vertex, rim[i]);
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(sheet.loads().pins.size(), 32U);
}

TEST(EmptyRegions, OfPinsAndConstraintsAreRefusedUnlessCutsMayFillThem) {
  const scene::MaterialBox nowhere{{2.0, 2.0}, {3.0, 3.0}};
  scene::SheetConfig config = flat(5);
  config.pins = {scene::RegionEdge::kTop, nowhere};
  EXPECT_EQ(refused(config), "REGION_EMPTY pins[1]");
  config.commands = {{1, scenes::line_cut({0.25, 0.5}, {0.75, 0.5})}};
  EXPECT_EQ(refused(config), "REGION_EMPTY pins[1]") << "pins are looked up at the start alone";
  config.pins.clear();
  config.commands.clear();
  config.constraints = {hold(scene::RegionEdge::kTop), hold(scene::MaterialLine{{0.3, 0.6}, {0.7, 0.6}})};
  EXPECT_EQ(refused(config), "REGION_EMPTY constraints[1].region");
  config.commands = {{1, scenes::line_cut({0.3, 0.6}, {0.7, 0.6})}};
  Sheet sheet = make(config);
  EXPECT_EQ(sheet.loads().pins.size(), 5U);
  sheet.step({});
  EXPECT_GT(sheet.loads().pins.size(), 7U);
  config.constraints = {hold(Vertices{})};
  EXPECT_EQ(refused(config), "REGION_EMPTY constraints[0].region") << "no cut adds to a list";
}

TEST(EmptyRegions, OfSetPinsAreRefusedAndLeaveThePins) {
  scene::SheetConfig config = flat(5);
  config.pins = {scene::RegionEdge::kTop};
  Sheet sheet = make(config);
  const TickReport report =
      sheet.apply(std::vector<scene::Command>{scene::SetPins{{scene::MaterialBox{{2.0, 2.0}, {3.0, 3.0}}}}});
  ASSERT_FALSE(report.replies[0].ok());
  EXPECT_EQ(report.replies[0].error().reason, "REGION_EMPTY");
  EXPECT_EQ(report.replies[0].error().field, "set_pins.pins[0]");
  EXPECT_EQ(sheet.pinned_vertices().size(), 5U);
}

TEST(CurveRegions, AreRefusedByName) {
  scene::SheetConfig config = flat(5);
  config.constraints = {hold(scene::MaterialCurve{cut::Circle{{0.0, 0.0}, 0.0}})};
  EXPECT_EQ(refused(config), "RADIUS_NOT_POSITIVE constraints[0].region.curve.curve.circle.radius_m");
  config.constraints = {hold(scene::MaterialCurve{cut::Circle{{0.0, 0.0}, 0.5}, 1.0e4 + 1.0})};
  EXPECT_EQ(refused(config), "OUT_OF_RANGE constraints[0].region.curve.within_m");
  config.constraints = {hold(scene::MaterialCurve{cut::Circle{{0.0, 0.0}, 0.5}, 1.0e4})};
  EXPECT_EQ(refused(config), "made");
  config.constraints = {hold(scene::NearestBorder{{0.0, std::nan("")}})};
  EXPECT_EQ(refused(config), "NOT_FINITE constraints[0].region.border.y");
}

}  // namespace
}  // namespace kerf::sheet
