#include "server/core/mesh/build/outline_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/mesh/refine/size_field.h"
#include "tests/mesh/measures.h"

namespace kerf::mesh {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;

OutlineContour polygon(const std::vector<Vector2d>& points, const std::string& field = "border") {
  OutlineContour contour{points, {}, field};
  for (std::size_t i = 0; i < points.size(); ++i) contour.corners.push_back(i);
  return contour;
}

OutlineContour rectangle(double width, double height) {
  return polygon({{0, 0}, {width, 0}, {width, height}, {0, height}});
}

OutlineContour ellipse(const Vector2d& centre, double a, double b, const std::string& field = "hole") {
  OutlineContour contour{{}, {}, field};
  constexpr int kPoints = 4000;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2.0 * pi * i / kPoints;
    contour.points.emplace_back(centre.x() + a * std::cos(angle), centre.y() + b * std::sin(angle));
  }
  return contour;
}

double total_area(const std::vector<Vector2d>& points) {
  double doubled = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector2d& a = points[i];
    const Vector2d& b = points[(i + 1) % points.size()];
    doubled += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * std::abs(doubled);
}

std::array<Vector2d, 3> corners_of(const TriangleMesh& mesh, TriangleId t) {
  const std::array<VertexId, 3>& v = mesh.vertices(t);
  return {mesh.rest_position(v[0]), mesh.rest_position(v[1]), mesh.rest_position(v[2])};
}

struct Quality {
  double least_angle = 180.0;         // degrees, at corners of the outline too
  double least_angle_forced = 180.0;  // of those between two edges of the border
  double mean = 0.0;                  // 4 sqrt(3) area / sum of squared edges
};

Quality quality_of(const TriangleMesh& mesh) {
  Quality quality;
  for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    const std::array<Vector2d, 3> p = corners_of(mesh, t);
    double squared = 0.0;
    for (int k = 0; k < 3; ++k) {
      const Vector2d u = p[next_corner(k)] - p[k], v = p[previous_corner(k)] - p[k];
      const double angle = std::acos(u.dot(v) / (u.norm() * v.norm())) * 180.0 / pi;
      const bool is_forced =
          mesh.neighbour(t, next_corner(k)) == kNone && mesh.neighbour(t, previous_corner(k)) == kNone;
      double& least = is_forced ? quality.least_angle_forced : quality.least_angle;
      least = std::min(least, angle);
      squared += u.squaredNorm();
    }
    quality.mean += 4.0 * std::numbers::sqrt3 * mesh.area(t) / squared / mesh.num_solid_triangles();
  }
  return quality;
}

bool has_vertex_at(const TriangleMesh& mesh, const Vector2d& at, double within) {
  for (VertexId v = 0; v < mesh.num_vertices(); ++v) {
    if ((mesh.rest_position(v) - at).norm() <= within) return true;
  }
  return false;
}

std::vector<Vector2d> border_vertices(const TriangleMesh& mesh) {
  std::vector<Vector2d> found;
  for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    for (int k = 0; k < 3 && mesh.is_solid(t); ++k) {
      if (mesh.neighbour(t, k) == kNone) found.push_back(mesh.rest_position(mesh.vertices(t)[next_corner(k)]));
    }
  }
  return found;
}

std::string reason(const OutlineConfig& config) {
  const Result<TriangleMesh> built = mesh_outline(config);
  return built.ok() ? "" : built.error().reason + " " + built.error().field;
}

// A closed curve around `centre`: smooth, or with corners.
OutlineContour blob(SeededRandom& random, const Vector2d& centre, double size, const std::string& field) {
  OutlineContour contour{{}, {}, field};
  const bool has_corners = random.below(2) == 0;
  const int count = has_corners ? 3 + static_cast<int>(random.below(9)) : 600;
  const double depth = random.uniform(0.0, 0.3), phase = random.uniform(0.0, 6.0);
  const int waves = 2 + static_cast<int>(random.below(6));
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * pi * i / count;
    const double radius =
        has_corners ? random.uniform(0.3, 1.0) : (1.0 + depth * std::sin(waves * angle + phase)) / (1.0 + depth);
    contour.points.push_back(centre + size * radius * Vector2d(std::cos(angle), std::sin(angle)));
    if (has_corners) contour.corners.push_back(static_cast<std::size_t>(i));
  }
  return contour;
}

OutlineConfig random_outline(std::uint64_t seed) {
  SeededRandom random(seed);
  OutlineConfig config;
  const Vector2d centre(random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0));
  config.contours.push_back(blob(random, centre, 1.0, "border"));
  const auto num_holes = static_cast<int>(random.below(5));
  for (int i = 0; i < num_holes; ++i) {
    const Vector2d offset(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
    config.contours.push_back(blob(random, centre + offset, std::pow(10.0, random.uniform(-3.0, -0.8)), "hole"));
  }
  config.edge_length = std::pow(10.0, random.uniform(-1.5, -0.3));
  const auto num_sizes = static_cast<int>(random.below(4));
  for (int i = 0; i < num_sizes; ++i) {
    const Vector2d offset(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    const double length = std::pow(10.0, random.uniform(-3.5, -1.0));
    config.sizes.push_back({{centre + offset}, length, std::pow(10.0, random.uniform(-1.0, 0.3)), "size"});
  }
  return config;
}

TEST(OutlineMesh, RandomOutlinesAreMeshedWellOrRefused) {
  int num_meshed = 0;
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    SCOPED_TRACE(seed);
    const OutlineConfig config = random_outline(seed);
    const Result<TriangleMesh> built = mesh_outline(config);
    if (!built.ok()) {  // holes are thrown in anywhere
      EXPECT_TRUE(built.error().reason == "OUTLINE_CROSSES" || built.error().reason == "OUTLINE_NESTING")
          << built.error().message;
      continue;
    }
    ++num_meshed;
    const TriangleMesh& mesh = *built;
    EXPECT_EQ(mesh.find_violation().value_or("none"), "none");
    EXPECT_EQ(mesh.num_pieces(), 1);
    EXPECT_EQ(mesh.num_boundary_loops(), static_cast<std::int32_t>(config.contours.size()));
    EXPECT_GE(quality_of(mesh).least_angle, 25.0 - 1e-6);
    double area = 0.0, perimeter_share = 0.0;
    for (const OutlineContour& contour : config.contours) {
      area += (&contour == config.contours.data() ? 1.0 : -1.0) * total_area(contour.points);
      if (contour.corners.empty()) perimeter_share += total_area(contour.points);
      for (const std::size_t corner : contour.corners) EXPECT_TRUE(has_vertex_at(mesh, contour.points[corner], 1e-12));
    }
    // Exactly where all is straight; else what chords that turn by up to pi / 8 and a half leave out.
    EXPECT_NEAR(total_area(mesh), area, 1e-12 + 0.08 * perimeter_share);
  }
  EXPECT_GE(num_meshed, 80);
}

TEST(OutlineMesh, TheSameEveryTime) {
  for (const std::uint64_t seed : {1U, 2U, 5U, 9U}) {
    const Result<TriangleMesh> a = mesh_outline(random_outline(seed)), b = mesh_outline(random_outline(seed));
    ASSERT_EQ(a.ok(), b.ok());
    if (a.ok()) {
      EXPECT_EQ(*a, *b);
    }
  }
}

TEST(OutlineMesh, PlainRegionsAreNearlyEquilateral) {
  OutlineConfig config;
  config.contours = {rectangle(1.0, 1.0), ellipse({0.5, 0.5}, 0.2, 0.2)};
  config.edge_length = 0.02;
  const TriangleMesh mesh = mesh_outline(config).value();
  const Quality quality = quality_of(mesh);
  EXPECT_GE(quality.mean, 0.98);
  EXPECT_GE(std::min(quality.least_angle, quality.least_angle_forced), 32.0);
  EXPECT_NEAR(mesh.num_vertices(), (1.0 - 0.04 * pi) / (0.5 * std::numbers::sqrt3 * 4e-4), 0.1 * mesh.num_vertices());
}

TEST(OutlineMesh, EdgesAreAboutAsLongAsAskedFor) {
  OutlineConfig config;
  config.contours = {rectangle(2.0, 1.0), ellipse({0.7, 0.5}, 0.2, 0.2)};
  config.edge_length = 0.1;
  config.sizes = {{{{0.9, 0.5}}, 0.001, 0.25, "a"}, {{{1.5, 0.1}, {1.5, 0.9}}, 0.01, 0.3, "b"}};
  const TriangleMesh mesh = mesh_outline(config).value();
  const SizeField wanted(0.1, {{{0.9, 0.5}, {0.9, 0.5}, 0.001, 0.25}, {{1.5, 0.1}, {1.5, 0.9}, 0.01, 0.3}});
  double sum = 0.0;
  std::int64_t count = 0, num_off = 0;
  for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    const std::array<Vector2d, 3> p = corners_of(mesh, t);
    for (int k = 0; k < 3; ++k) {
      const double ratio = (p[k] - p[next_corner(k)]).norm() / wanted.at(0.5 * (p[k] + p[next_corner(k)]));
      EXPECT_LT(ratio, 2.0);
      EXPECT_GT(ratio, 0.45);
      if (ratio < 0.6 || ratio > 1.5) ++num_off;
      sum += ratio;
      ++count;
    }
  }
  EXPECT_NEAR(sum / static_cast<double>(count), 1.0, 0.1);
  EXPECT_LE(num_off, count / 50);
}

TEST(OutlineMesh, VerticesLieOnCurvesAndCornersAreVertices) {
  OutlineConfig config;
  config.contours = {rectangle(1.0, 0.5), ellipse({0.5, 0.25}, 0.1, 0.05)};
  const TriangleMesh mesh = mesh_outline(config).value();
  for (const Vector2d& corner : config.contours[0].points) EXPECT_TRUE(has_vertex_at(mesh, corner, 0.0));
  int num_on_hole = 0;
  for (const Vector2d& p : border_vertices(mesh)) {
    if (p.x() == 0.0 || p.x() == 1.0 || p.y() == 0.0 || p.y() == 0.5) continue;
    ++num_on_hole;
    EXPECT_NEAR(std::hypot((p.x() - 0.5) / 0.1, (p.y() - 0.25) / 0.05), 1.0, 1e-9);
  }
  EXPECT_GE(num_on_hole, 16);  // however long the edges may be, here 1/32 of a metre
}

TEST(OutlineMesh, ASmallHoleIsRoundAndNarrowPlacesAreResolved) {
  OutlineConfig config;
  config.contours = {rectangle(1.0, 1.0), ellipse({0.3, 0.3}, 0.005, 0.005), ellipse({0.7, 0.7}, 0.1, 0.1),
                     ellipse({0.7, 0.8505}, 0.05, 0.05)};
  config.edge_length = 0.2;
  const TriangleMesh mesh = mesh_outline(config).value();
  EXPECT_GE(quality_of(mesh).least_angle, 25.0 - 1e-6);
  const std::vector<Vector2d> border = border_vertices(mesh);
  const auto num_small = std::count_if(border.begin(), border.end(),
                                       [](const Vector2d& p) { return (p - Vector2d(0.3, 0.3)).norm() < 0.006; });
  EXPECT_GE(num_small, 16);
  EXPECT_LE(num_small, 40);
  EXPECT_LE(mesh.num_vertices(), 2000);
}

TEST(OutlineMesh, SharpCornersOfTheOutlineStayAndEnd) {
  for (const double height : {0.2, 0.02, 0.002}) {
    OutlineConfig config;
    config.contours = {polygon({{0, 0}, {1, 0}, {1, height}})};
    config.edge_length = 0.1;
    const TriangleMesh mesh = mesh_outline(config).value();
    EXPECT_NEAR(total_area(mesh), 0.5 * height, 1e-15);
    EXPECT_NEAR(quality_of(mesh).least_angle_forced, std::atan(height) * 180.0 / pi, 1e-6);
    EXPECT_GE(quality_of(mesh).least_angle, 25.0 - 1e-6);
  }
}

TEST(OutlineMesh, MinAngleIsKept) {
  for (const double angle : {5.0, 20.0, kMaxOutlineAngle}) {
    OutlineConfig config;
    config.contours = {polygon({{0, 0}, {1, 0}, {0.3, 0.25}, {0, 1}}), ellipse({0.2, 0.2}, 0.01, 0.15)};
    config.edge_length = 0.1;
    config.min_angle_deg = angle;
    EXPECT_GE(quality_of(mesh_outline(config).value()).least_angle, angle - 1e-6);
  }
}

TEST(OutlineMesh, FarFromTheOriginAndAtTheEdgeOfResolution) {
  OutlineConfig config;
  config.contours = {polygon({{9000, -9000}, {9000.001, -9000}, {9000.001, -8999.999}, {9000, -8999.999}})};
  EXPECT_GE(quality_of(mesh_outline(config).value()).least_angle, 25.0 - 1e-3);  // rounded positions
  config.contours = {rectangle(1.0, 1.0)};
  config.edge_length = 0.1;
  config.sizes = {{{{0.5, 0.5}}, 1e-9, 0.25, "tip"}};
  const Result<TriangleMesh> finest = mesh_outline(config);
  ASSERT_TRUE(finest.ok()) << finest.error().message;
  EXPECT_GE(quality_of(*finest).least_angle, 25.0 - 1e-6);
  config.sizes[0].length = 0.999e-9;
  EXPECT_EQ(reason(config), "OUTLINE_EDGE_LENGTH tip");
  config.sizes.clear();
  config.edge_length = 0.999e-9;
  EXPECT_EQ(reason(config), "OUTLINE_EDGE_LENGTH edge_length");
}

TEST(OutlineMesh, RefusesMoreVerticesThanAllowed) {
  OutlineConfig config;
  config.contours = {rectangle(1.0, 1.0), ellipse({0.5, 0.5}, 0.2, 0.1)};
  config.edge_length = 0.03;
  const std::int32_t needed = mesh_outline(config).value().num_vertices();
  config.max_vertices = needed;
  EXPECT_EQ(mesh_outline(config).value().num_vertices(), needed);
  config.max_vertices = needed - 1;
  EXPECT_EQ(reason(config), "OUTLINE_TOO_FINE edge_length");
  config.max_vertices = kMaxVertices;
  config.edge_length = 1e-7;  // 1e14 vertices: nothing of the kind is begun
  EXPECT_EQ(reason(config), "OUTLINE_TOO_FINE edge_length");
  config.edge_length = 0.1;
  config.sizes = {{{{0.0, 0.0}, {1.0, 0.0}}, 1e-7, 0.25, "side"}};
  EXPECT_EQ(reason(config), "OUTLINE_TOO_FINE edge_length");
  config.sizes = {{{{0.1, 0.1}, {0.9, 0.1}}, 1e-6, 0.01, "inside"}};
  EXPECT_EQ(reason(config), "OUTLINE_TOO_FINE edge_length");
}

TEST(OutlineMesh, RefusesWhatIsNoOutline) {
  const OutlineContour square = rectangle(1.0, 1.0);
  const auto of = [](std::vector<OutlineContour> contours) {
    OutlineConfig config;
    config.contours = std::move(contours);
    return reason(config);
  };
  EXPECT_EQ(of({polygon({{0, 0}, {1, 0}})}), "OUTLINE_DEGENERATE border");
  EXPECT_EQ(of({polygon({{0, 0}, {1, 0}, {1, 0}, {0, 0}})}), "OUTLINE_DEGENERATE border");
  EXPECT_EQ(of({polygon({{0, 0}, {1e-10, 0}, {0, 1e-10}})}), "OUTLINE_DEGENERATE border");
  EXPECT_EQ(of({polygon({{0, 0}, {1, 0}, {2, 0}})}), "OUTLINE_CROSSES border");
  EXPECT_EQ(of({polygon({{0, 0}, {1, 1}, {1, 0}, {0, 1}})}), "OUTLINE_CROSSES border");
  EXPECT_EQ(of({polygon({{0, 0}, {1, 0}, {1, 1}, {0.5, 0}, {0, 1}})}), "OUTLINE_CROSSES border");
  EXPECT_EQ(of({polygon({{0, 0}, {1, 0}, {0.5, 0}, {0.5, 1}})}), "OUTLINE_CROSSES border");  // back along itself
  EXPECT_EQ(of({square, ellipse({0.5, 0.5}, 0.6, 0.1)}), "OUTLINE_CROSSES hole");
  EXPECT_EQ(of({square, polygon({{0, 0}, {0.5, 0.2}, {0.2, 0.5}}, "hole")}), "OUTLINE_CROSSES hole");
  EXPECT_EQ(of({square, ellipse({1.5, 0.5}, 0.2, 0.1)}), "OUTLINE_NESTING hole");
  EXPECT_EQ(of({ellipse({0.5, 0.5}, 0.1, 0.1, "border"), polygon({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, "hole")}),
            "OUTLINE_NESTING hole");
  EXPECT_EQ(of({square, ellipse({0.5, 0.5}, 0.2, 0.2), ellipse({0.5, 0.5}, 0.1, 0.1, "inner")}),
            "OUTLINE_NESTING inner");
  // The smallest distinguishable distance is near enough.
  EXPECT_EQ(of({square, polygon({{1e-4, 0.5}, {0.5, 0.4}, {0.5, 0.6}}, "hole")}), "");
}

TEST(OutlineMesh, LongEdgesNeverStandForACurveWithSomethingBetween) {
  // A hole in the bay of a border whose own edges would pass it by, were they as long as asked for.
  OutlineContour bay{{}, {}, "border"};
  for (int i = 0; i <= 1000; ++i) {
    const double angle = pi * (1.0 - 0.001 * i);
    bay.points.emplace_back(4.0 * std::cos(angle), 0.6 * std::sin(angle));
  }
  for (const Vector2d& p : {Vector2d(4.5, 0.0), Vector2d(4.5, 2.0), Vector2d(-4.5, 2.0), Vector2d(-4.5, 0.0)}) {
    bay.corners.push_back(bay.points.size());
    bay.points.push_back(p);
  }
  OutlineConfig config;
  config.contours = {bay, ellipse({0.0, 0.65}, 0.02, 0.02)};
  config.edge_length = 4.0;
  const Result<TriangleMesh> built = mesh_outline(config);
  ASSERT_TRUE(built.ok()) << built.error().message;
  EXPECT_EQ(built->num_boundary_loops(), 2);
  EXPECT_GE(quality_of(*built).least_angle, 25.0 - 1e-6);
}

}  // namespace
}  // namespace kerf::mesh
