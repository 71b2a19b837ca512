// Probes that count where a sheet passes through itself, in all analyses. What counts: tests/contact.
#include <cmath>

#include "server/core/analysis/analysis.h"
#include "server/core/analysis/probe.h"
#include "server/core/fem/statics/equilibrium.h"
#include "server/core/fem/statics/equilibrium_options.h"
#include "tests/sheet/calls.h"

namespace kerf::analysis {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Rows = std::vector<std::vector<double>>;

scene::Probe intersections() {
  scene::Probe probe;
  probe.name = "n";
  probe.quantity = scene::Quantity::kIntersections;
  return probe;
}

double num_pairs(const sheet::Sheet& sheet) {
  std::vector<double> row;
  Probes::create({intersections()}, sheet)->measure(sheet, {}, 0.0, row);
  return row.at(0);
}

// Every vertex is moved by a constraint, from the plane into a loop that passes through itself.
scene::SheetConfig looping() {
  scene::SheetConfig config = scenes::flat(15);
  const sheet::Sheet flat = sheet::make(config);
  std::vector<mesh::VertexId> vertices;
  scene::Constraint all;
  all.displacements.setZero(3, flat.mesh().num_vertices());
  for (mesh::VertexId v = 0; v < flat.mesh().num_vertices(); ++v) {
    vertices.push_back(v);
    const Vector2d at = flat.mesh().rest_position(v);
    const double s = 4.0 * at.x() - 2.0;
    all.displacements.col(v) = Vector3d(0.1 * (s * s * s - 2.0 * s) - at.x(), 0.01 * at.x(), 0.1 * s * s);
  }
  all.region = vertices;
  config.constraints = {all};
  config.probes = {intersections()};
  return config;
}

// A bent, inclined sheet as an array.
scene::SheetConfig waved() {
  scene::SheetConfig config = scenes::flat(25);
  const sheet::Sheet flat = sheet::make(config);
  scene::ArraySource source;
  const mesh::VertexId count = flat.mesh().num_vertices();
  source.material_positions.resize(2, count);
  source.positions.resize(3, count);
  for (mesh::VertexId v = 0; v < count; ++v) {
    const Vector2d at = flat.mesh().rest_position(v);
    source.material_positions.col(v) = at;
    source.positions.col(v) = Vector3d(0.8 * at.x() - 0.3 * at.y(), 0.7 * at.y() + 0.1 * at.x(),
                                       0.45 * at.x() + 0.1 * std::sin(7.0 * at.x() + 4.0 * at.y()));
  }
  source.triangles.resize(3, flat.mesh().num_solid_triangles());
  for (mesh::TriangleId t = 0; t < flat.mesh().num_solid_triangles(); ++t) {
    for (int k = 0; k < 3; ++k) source.triangles(k, t) = flat.mesh().vertices(t)[static_cast<std::size_t>(k)];
  }
  config.mesh = source;
  return config;
}

TEST(IntersectionsProbe, CountsAtLoads) {
  const scene::SheetConfig config = looping();
  sheet::Sheet sheet = sheet::make(config);
  const Result<Outcome> outcome = run_static(sheet, {.loads = {0.01, 1.0}}, config.probes, {});
  ASSERT_TRUE(outcome.ok());
  const Table& table = outcome->tables.at(0);
  EXPECT_EQ(table.columns, (std::vector<std::string>{"load", "n.pairs"}));
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_EQ(table.rows[0][1], 0.0);
  EXPECT_GT(table.rows[1][1], 14.0) << "along a line across the sheet";
}

TEST(IntersectionsProbe, CountsAboutVibrations) {
  scene::SheetConfig config = looping();
  config.constraints[0].displacements.col(0).setZero();
  scene::Constraint& all = config.constraints[0];
  std::get<std::vector<mesh::VertexId>>(all.region.shape).resize(200);  // others stay free
  all.displacements.conservativeResize(3, 200);
  all.displacements.setZero();
  sheet::Sheet sheet = sheet::make(config);
  const Result<Outcome> outcome = run_modes(sheet, {1, scene::StaticAnalysis{}}, config.probes, {});
  ASSERT_TRUE(outcome.ok()) << outcome.error().message;
  EXPECT_EQ(outcome->tables.at(0).rows, (Rows{{1.0, 0.0}}));
}

TEST(IntersectionsProbe, CountsInTime) {
  scene::SheetConfig config = looping();
  config.constraints[0].history = {{0.0, 0.1}, {0.0, 1.0}};
  sheet::Sheet sheet = sheet::make(config);
  const Result<Outcome> outcome = run_dynamic(sheet, {.ticks = 8}, config.probes, {}, {}, nullptr);
  ASSERT_TRUE(outcome.ok());
  const Rows& rows = outcome->tables.at(0).rows;
  ASSERT_EQ(rows.size(), 9U);
  EXPECT_EQ(rows.front().at(1), 0.0);
  EXPECT_GT(rows.back().at(1), 14.0);
  EXPECT_EQ(rows.back().at(1), num_pairs(sheet)) << "by a probe of its own";
}

// The lips of a cut are at the same places when it is made.
TEST(IntersectionsProbe, CountsNoneOfLipsThatCoincide) {
  sheet::Sheet sheet = sheet::make(waved());
  scene::Cut circle;
  circle.curve = cut::Circle{{0.5, 0.5}, 0.19};
  for (const scene::Cut& cut : {scenes::line_cut({0.1, 0.23}, {0.93, 0.81}), scenes::line_cut({0.2, 0.9}, {0.71, 0.1}),
                                scenes::line_cut({-0.1, 0.4}, {1.1, 0.44}), circle}) {
    ASSERT_TRUE(sheet::apply(sheet, cut).ok());
    EXPECT_EQ(num_pairs(sheet), 0.0);
  }
  EXPECT_GT(sheet.mesh().num_pieces(), 3);
}

// Triangles that a cut removes are not counted.
TEST(IntersectionsProbe, FollowsCutsThatRemoveMaterial) {
  scene::SheetConfig config = looping();
  sheet::Sheet sheet = sheet::make(config);
  ASSERT_TRUE(sheet.settle(1.0, {}, {}).converged);
  Result<Probes> probes = Probes::create(config.probes, sheet);
  ASSERT_TRUE(probes.ok());
  const auto count = [&] {
    std::vector<double> row;
    probes->measure(sheet, {}, 0.0, row);
    return row.at(0);
  };
  const double before = count();
  EXPECT_GT(before, 14.0);
  scene::Cut half = scenes::line_cut({0.3, -0.2}, {0.3, 1.2});
  half.options.width_m = 0.7;  // one of the two ends that pass through each other
  ASSERT_TRUE(sheet::apply(sheet, half).ok());
  EXPECT_EQ(count(), 0.0);
}

TEST(IntersectionsProbe, TakesNoPlace) {
  scene::Probe probe = intersections();
  EXPECT_TRUE(scene::validate(std::vector<scene::Probe>{probe}).ok());
  probe.points = {{0.5, 0.5}};
  EXPECT_EQ(scene::validate(std::vector<scene::Probe>{probe}).error().reason, "PLACE_UNUSED");
}

}  // namespace
}  // namespace kerf::analysis
