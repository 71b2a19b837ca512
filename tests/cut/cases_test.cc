// The hard cases of cutting, each with the exact number of pieces and of boundary loops, under random placement.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/cut/cut.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "server/core/mesh/build/mesh_import.h"
#include "tests/cut/calls.h"
#include "tests/support/meshes.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

constexpr int kVertices = 13;         // a side
constexpr double kCell = 1.0 / 12.0;  // edge length on a unit sheet

// A similarity: curves are given on the unit square and carried onto a sheet of another size.
struct Placement {
  double scale = 1.0;
  double angle = 0.0;
  Vector2d shift{0.0, 0.0};

  [[nodiscard]] Vector2d operator()(const Vector2d& p) const {
    const Vector2d centred = p - Vector2d(0.5, 0.5);
    const Vector2d turned(std::cos(angle) * centred.x() - std::sin(angle) * centred.y(),
                          std::sin(angle) * centred.x() + std::cos(angle) * centred.y());
    return scale * (turned + shift + Vector2d(0.5, 0.5));
  }
  [[nodiscard]] Curve operator()(const Curve& curve) const {
    Curve placed = curve;
    if (auto* line = std::get_if<Polyline>(&placed)) {
      for (Vector2d& p : line->points) p = (*this)(p);
    } else if (auto* bezier = std::get_if<CubicBezier>(&placed)) {
      for (Vector2d& p : bezier->points) p = (*this)(p);
    } else if (auto* circle = std::get_if<Circle>(&placed)) {
      circle->centre = (*this)(circle->centre);
      circle->radius *= scale;
    }
    return placed;
  }
};

struct PlacedCase {
  const char* name;
  std::vector<Curve> curves;  // cut one after the other
  int pieces;
  int loops;
  CutStatus last = CutStatus::kApplied;
};

mesh::TriangleMesh sheet(bool jittered, double size = 1.0, std::uint64_t seed = 1) {
  const mesh::GridConfig config{kVertices, kVertices, size, size};
  auto made = jittered ? mesh::make_jittered_grid(config, seed) : mesh::make_grid(config);
  return *made;
}

void check_case(const PlacedCase& item, mesh::TriangleMesh mesh, const Placement& place,
                const CutOptions& options = {}) {
  CutStatus last = CutStatus::kNoIntersection;
  for (const Curve& curve : item.curves) last = cut(mesh, {place(curve), options, {}}).status;
  EXPECT_EQ(last, item.last);
  EXPECT_EQ(mesh.num_pieces(), item.pieces);
  EXPECT_EQ(count_boundary_loops(mesh), item.loops);
}

Curve line(std::vector<Vector2d> points) {
  return Polyline{std::move(points)};
}

Curve wave(const Vector2d& a, const Vector2d& b, double height, int count) {
  Polyline result;
  const Vector2d across = height * Vector2d(a.y() - b.y(), b.x() - a.x()).normalized();
  for (int i = 0; i <= count; ++i) {
    result.points.push_back(a + (static_cast<double>(i) / count) * (b - a) + (i % 2 == 0 ? -1.0 : 1.0) * across);
  }
  return result;
}

Curve spiral(double reach, double turns) {
  Polyline result;
  for (int i = 0; i <= 80; ++i) {
    const double t = i / 80.0;
    const double angle = 2.0 * std::numbers::pi * turns * t;
    result.points.emplace_back(0.5 + reach * t * std::cos(angle), 0.5 + reach * t * std::sin(angle));
  }
  return result;
}

std::vector<Curve> star(int arms, double reach) {
  std::vector<Curve> curves;
  for (int i = 0; i < arms; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / arms + 0.3;
    curves.push_back(line({{0.5, 0.5}, {0.5 + reach * std::cos(angle), 0.5 + reach * std::sin(angle)}}));
  }
  return curves;
}

std::vector<Curve> comb(int teeth) {
  std::vector<Curve> curves{line({{0.3, 0.4}, {0.7, 0.4}})};
  for (int i = 0; i < teeth; ++i) {
    const double x = 0.32 + 0.36 * i / (teeth - 1);
    curves.push_back(line({{x, 0.4}, {x, 0.63}}));
  }
  return curves;
}

// All inside the sheet whatever the rotation and the shift of up to 0.1.
std::vector<PlacedCase> cases_inside() {
  const Curve slit = line({{0.3, 0.45}, {0.72, 0.55}});
  const Curve bezier = CubicBezier{{{0.3, 0.4}, {0.5, 0.8}, {0.5, 0.2}, {0.7, 0.6}}};
  const double tiny = 0.05 * kCell;
  const Vector2d c(0.513, 0.487);
  std::vector<PlacedCase> cases{
      {"slit", {slit}, 1, 2},
      {"bezier slit", {bezier}, 1, 2},
      {"closed polygon", {line({{0.35, 0.35}, {0.65, 0.4}, {0.5, 0.7}, {0.35, 0.35}})}, 2, 3},
      {"punch", {Circle{{0.5, 0.5}, 0.2}}, 2, 3},
      {"punch in a punch", {Circle{{0.5, 0.5}, 0.25}, Circle{{0.52, 0.5}, 0.1}}, 3, 5},
      {"overlapping punches", {Circle{{0.45, 0.5}, 0.15}, Circle{{0.55, 0.5}, 0.15}}, 4, 5},
      {"open inside one element", {line({c, c + Vector2d(tiny, 0.3 * tiny)})}, 1, 2},
      {"closed inside one element", {Circle{c, tiny}}, 2, 3},
      {"kinked inside one element", {wave(c, c + Vector2d(3 * tiny, 0), tiny, 6)}, 1, 2},
      {"crossing", {slit, line({{0.5, 0.3}, {0.52, 0.7}})}, 1, 2},
      {"T", {slit, line({{0.51, 0.5}, {0.45, 0.7}})}, 1, 2},
      {"star", star(7, 0.25), 1, 2},
      {"comb", comb(6), 1, 2},
      {"spiral", {spiral(0.3, 3.0)}, 1, 2},
      {"figure 8", {line({{0.3, 0.35}, {0.7, 0.65}, {0.7, 0.35}, {0.3, 0.65}, {0.3, 0.35}})}, 3, 4},
      {"loop with tails", {line({{0.3, 0.3}, {0.6, 0.6}, {0.4, 0.65}, {0.65, 0.35}})}, 2, 3},
      {"same cut twice", {slit, slit}, 1, 2, CutStatus::kNoIntersection},
      {"same bezier twice", {bezier, bezier}, 1, 2, CutStatus::kNoIntersection},
      {"same punch twice", {Circle{{0.5, 0.5}, 0.2}, Circle{{0.5, 0.5}, 0.2}}, 2, 3, CutStatus::kNoIntersection},
      {"part of it again", {slit, line({{0.342, 0.46}, {0.594, 0.52}})}, 1, 2, CutStatus::kNoIntersection},
      {"backwards", {slit, line({{0.72, 0.55}, {0.3, 0.45}})}, 1, 2, CutStatus::kNoIntersection},
      {"there and back", {line({{0.3, 0.45}, {0.72, 0.55}, {0.4, 0.47380952380952384}})}, 1, 2},
      {"half overlapping", {line({{0.3, 0.5}, {0.6, 0.5}}), line({{0.45, 0.5}, {0.72, 0.5}})}, 1, 2},
      {"along a lip, then off", {line({{0.3, 0.5}, {0.6, 0.5}}), line({{0.4, 0.5}, {0.5, 0.5}, {0.5, 0.7}})}, 1, 2},
      {"closing a U",
       {line({{0.4, 0.65}, {0.4, 0.4}, {0.6, 0.4}, {0.6, 0.65}}), line({{0.35, 0.6}, {0.65, 0.6}})},
       2,
       3},
      {"joining two slits",
       {line({{0.4, 0.3}, {0.4, 0.7}}), line({{0.6, 0.3}, {0.6, 0.7}}), line({{0.4, 0.5}, {0.6, 0.5}})},
       1,
       2},
      {"window",
       {line({{0.4, 0.3}, {0.4, 0.7}}), line({{0.6, 0.3}, {0.6, 0.7}}), line({{0.35, 0.4}, {0.65, 0.4}}),
        line({{0.35, 0.6}, {0.65, 0.6}})},
       2,
       3},
      {"coincident points", {line({{0.3, 0.5}, {0.3, 0.5}, {0.5, 0.6}, {0.5, 0.6}, {0.5, 0.6}, {0.7, 0.5}})}, 1, 2},
      {"cusp", {CubicBezier{{{0.35, 0.4}, {0.65, 0.7}, {0.35, 0.7}, {0.65, 0.4}}}}, 1, 2},
      {"dense polyline", {wave({0.3, 0.5}, {0.7, 0.5}, 0.01 * kCell, 200)}, 1, 2},
  };
  return cases;
}

TEST(CutCases, CountsHoldUnderRigidMotionAndScale) {
  SeededRandom random(11);
  for (const PlacedCase& item : cases_inside()) {
    for (int trial = 0; trial < kPlacements && !testing::Test::HasFailure(); ++trial) {
      SCOPED_TRACE(std::string(item.name) + " placement " + std::to_string(trial));
      const double sizes[] = {1.0, 1e-3, 250.0};
      const Placement place{
          sizes[trial % 3], trial == 0 ? 0.0 : random.uniform(0.0, 6.28),
          trial == 0 ? Vector2d(0.0, 0.0) : Vector2d(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1))};
      CutOptions options;
      options.relax = trial % 2 == 0;
      check_case(item, sheet(trial % 4 >= 2, place.scale, random.next()), place, options);
    }
  }
}

// Placed with respect to elements and border; in place and off by far less than the snap distance.
std::vector<PlacedCase> cases_in_place() {
  const double g = kCell;
  const auto at = [g](double i, double j) { return Vector2d(i * g, j * g); };
  return {
      {"through a vertex", {line({at(3.3, 3.7), at(6.7, 6.3) /* passes (5, 5) */})}, 1, 2},
      {"through a vertex, axis", {line({at(3.5, 5), at(6.5, 5)})}, 1, 2},
      {"along edges", {line({at(3, 5), at(8, 5)})}, 1, 2},
      {"along diagonals", {line({at(3, 3), at(8, 8)})}, 1, 2},
      {"along one edge", {line({at(4, 5), at(5, 5)})}, 1, 2},
      {"part of one edge", {line({at(4.2, 5), at(4.7, 5)})}, 1, 2},
      {"ends on an edge", {line({at(3.2, 3.4), at(6.5, 6)})}, 1, 2},
      {"ends on a vertex", {line({at(3.2, 3.4), at(7, 6)})}, 1, 2},
      {"ends on the border", {line({at(5.3, 5.4), at(12, 6.2)})}, 1, 1},
      {"ends on a border vertex", {line({at(5.3, 5.4), at(12, 6)})}, 1, 1},
      {"border to inside", {line({at(-1, 5.5), at(5, 5.7)})}, 1, 1},
      {"border to border", {line({at(-1, 5.5), at(13, 6.7)})}, 2, 2},
      {"corner to corner", {line({at(0, 0), at(12, 12)})}, 2, 2},
      {"corner to corner across", {line({at(0, 12), at(12, 0)})}, 2, 2},
      {"corner clipped", {line({at(-1, 2), at(2, -1)})}, 2, 2},
      {"cross of two", {line({at(-1, 5.5), at(13, 6.7)}), line({at(5.5, -1), at(6.7, 13)})}, 4, 4},
      {"leaves and comes back", {line({at(4, 4.5), at(-2, 5), at(-2, 7), at(4, 7.5)})}, 1, 1},
      {"leaves and comes back, closed", {line({at(4, 4.5), at(-2, 5), at(-2, 7), at(4, 7.5), at(4, 4.5)})}, 2, 2},
      // Starts inside: one slit from the border, and four corners cut off.
      {"wave over the border", {wave(at(0, 2.2), at(0, 9.7), 0.7 * g, 9)}, 5, 5},
      {"same edge many times", {wave(at(4.55, 5.1), at(4.55, 5.9), 0.3 * g, 17)}, 1, 2},
      {"wave along an edge", {wave(at(5.05, 5), at(5.95, 5), 0.08 * g, 9)}, 1, 2},
      {"1-triangle island", {line({at(5, 5), at(6, 5), at(6, 6), at(5, 5)})}, 2, 3},
      {"loop touching the border", {line({at(0, 5), at(2.5, 4.1), at(2.6, 6.2), at(0, 5)})}, 2, 2},
      {"loop with a side on the border", {line({at(0, 4), at(2.5, 4.1), at(2.6, 6.2), at(0, 6), at(0, 4)})}, 2, 2},
      {"punch touching a slit", {line({at(3, 6), at(9, 6)}), line({at(6, 6), at(7, 8), at(5, 8), at(6, 6)})}, 2, 3},
      {"along the border", {line({at(0, 2), at(0, 9)})}, 1, 1, CutStatus::kNoIntersection},
      {"beside the border", {line({at(-0.5, -1), at(-0.5, 13)})}, 1, 1, CutStatus::kNoIntersection},
      {"far outside", {Circle{{50.0, 20.0}, 3.0}}, 1, 1, CutStatus::kNoIntersection},
      {"around the sheet", {Circle{{0.5, 0.5}, 5.0}}, 1, 1, CutStatus::kNoIntersection},
      {"touching a corner", {line({at(-1, 1), at(1, -1)})}, 1, 1, CutStatus::kNoIntersection},
      {"whole border",
       {line({at(0, 0), at(12, 0), at(12, 12), at(0, 12), at(0, 0)})},
       1,
       1,
       CutStatus::kNoIntersection},
      {"from very far", {line({{-9000.0, 0.47}, {9000.0, 0.53}})}, 2, 2},
      {"from a slit out", {line({at(3, 6), at(9, 6)}), line({at(6, 6), at(6.3, 14)})}, 1, 1},
      {"slit end to slit end", {line({at(3, 6), at(6, 6)}), line({at(6, 6), at(9, 6)})}, 1, 2},
  };
}

TEST(CutCases, CountsHoldRelativeToElementsAndBorder) {
  SeededRandom random(12);
  for (const PlacedCase& item : cases_in_place()) {
    for (int trial = 0; trial < kPlacements / 5 + 4 && !testing::Test::HasFailure(); ++trial) {
      SCOPED_TRACE(std::string(item.name) + " trial " + std::to_string(trial));
      CutOptions options;
      options.relax = trial % 2 == 0;
      Placement place;
      if (trial >= 4) place.shift = Vector2d(random.uniform(-1e-9, 1e-9), random.uniform(-1e-9, 1e-9));
      // A shift may let a touch pass for a crossing on either side: keep those in place.
      if (item.last == CutStatus::kNoIntersection) place.shift.setZero();
      check_case(item, sheet(trial % 4 >= 2), place, options);
    }
  }
}

// A grid of cells on the unit square turned by `angle`, with the cells for which `keep` is false left out: slanted
// borders, holes, several components, two regions.
template <typename Keep>
mesh::TriangleMesh turned_sheet(int cells, double angle, Keep keep) {
  mesh::IndexedMesh input;
  std::vector<int> used(static_cast<std::size_t>((cells + 1) * (cells + 1)), mesh::kNone);
  std::vector<Vector2d> positions;
  std::vector<Eigen::Vector3i> triangles;
  const Placement place{1.0, angle, {0.0, 0.0}};
  const auto vertex = [&](int i, int j) {
    int& id = used[static_cast<std::size_t>(j * (cells + 1) + i)];
    if (id == mesh::kNone) {
      id = static_cast<int>(positions.size());
      positions.push_back(place(Vector2d(i, j) / cells));
    }
    return id;
  };
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      if (!keep(i, j)) continue;
      triangles.emplace_back(vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1));
      triangles.emplace_back(vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1));
      input.regions.insert(input.regions.end(), 2, i < cells / 2 ? 0 : 1);
    }
  }
  input.rest.resize(2, static_cast<Eigen::Index>(positions.size()));
  for (std::size_t i = 0; i < positions.size(); ++i) input.rest.col(static_cast<Eigen::Index>(i)) = positions[i];
  input.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t i = 0; i < triangles.size(); ++i) input.triangles.col(static_cast<Eigen::Index>(i)) = triangles[i];
  Result<mesh::TriangleMesh> made = mesh::import_mesh(input);
  EXPECT_TRUE(made.ok()) << made.error().message;
  return std::move(*made);
}

TEST(CutCases, SheetsWithHolesComponentsRegionsAndSlantedBorders) {
  SeededRandom random(13);
  for (int trial = 0; trial < 12; ++trial) {
    SCOPED_TRACE("trial " + std::to_string(trial));
    const double angle = random.uniform(0.0, 6.28);
    const Placement place{1.0, angle, {0.0, 0.0}};
    // A frame with a hole in the middle: a straight cut through both sides gives two pieces, half of it one.
    const auto frame = [](int i, int j) { return i < 3 || i > 6 || j < 3 || j > 6; };
    mesh::TriangleMesh mesh = turned_sheet(10, angle, frame);
    EXPECT_EQ(count_boundary_loops(mesh), 2);
    cut(mesh, {place(line({{-0.1, 0.47}, {0.5, 0.52}})), {}, {}});
    EXPECT_EQ(mesh.num_pieces(), 1);
    EXPECT_EQ(count_boundary_loops(mesh), 1);
    cut(mesh, {place(line({{0.5, 0.52}, {1.1, 0.47}})), {}, {}});
    EXPECT_EQ(mesh.num_pieces(), 2);
    EXPECT_EQ(count_boundary_loops(mesh), 2);
    // A circle in the material around the hole frees a ring within a ring.
    mesh::TriangleMesh ring = turned_sheet(10, angle, frame);
    cut(ring, {place(Circle{{0.5, 0.5}, 0.4}), {}, {}});
    EXPECT_EQ(ring.num_pieces(), 2);
    EXPECT_EQ(count_boundary_loops(ring), 4);
    // Three strips side by side, cut across in one stroke.
    mesh::TriangleMesh strips = turned_sheet(11, angle, [](int i, int) { return i % 4 != 3; });
    EXPECT_EQ(strips.num_pieces(), 3);
    cut(strips, {place(line({{-0.2, 0.41}, {1.2, 0.62}})), {}, {}});
    EXPECT_EQ(strips.num_pieces(), 6);
    EXPECT_EQ(count_boundary_loops(strips), 6);
  }
}

// The lattice leaves less than an edge length of room around such sheets.
TEST(CutCases, SheetsOfOneOrTwoTrianglesAreCutInEveryDirection) {
  mesh::IndexedMesh slanted;
  slanted.rest.resize(2, 4);
  slanted.rest << 0.0, 3.0, 2.0, -1.0, 0.0, 1.0, 4.0, 3.0;
  slanted.triangles.resize(3, 2);
  slanted.triangles << 0, 0, 1, 2, 2, 3;
  const std::vector<std::pair<const char*, mesh::TriangleMesh>> sheets{
      {"square of 1 m", *mesh::make_grid({2, 2, 1.0, 1.0})},
      {"square of 0.7 m", *mesh::make_grid({2, 2, 0.7, 0.7})},
      {"rectangle", *mesh::make_grid({2, 2, 2.0, 1.0})},
      {"triangle", *mesh::import_mesh(test::one_triangle())},
      {"slanted", *mesh::import_mesh(slanted)},
  };
  for (const auto& [name, fresh] : sheets) {
    const Vector2d middle = (fresh.rest_position(0) + fresh.rest_position(1) + fresh.rest_position(2)) / 3.0;
    for (int i = 0; i < 72; ++i) {
      SCOPED_TRACE(std::string(name) + ", " + std::to_string(5 * i) + " degrees");
      const double angle = std::numbers::pi * (i / 36.0) + 0.01;
      const Vector2d far = middle + 9.0 * Vector2d(std::cos(angle), std::sin(angle));
      mesh::TriangleMesh out = fresh;
      EXPECT_EQ(cut(out, {line({middle, far}), {}, {}}).status, CutStatus::kApplied);
      EXPECT_EQ(out.num_pieces(), 1);
      mesh::TriangleMesh in = fresh;
      EXPECT_EQ(cut(in, {line({far, middle}), {}, {}}).status, CutStatus::kApplied);
      EXPECT_EQ(in.num_pieces(), 1);
      mesh::TriangleMesh through = fresh;
      EXPECT_EQ(cut(through, {line({far, 2.0 * middle - far}), {}, {}}).status, CutStatus::kApplied);
      EXPECT_EQ(through.num_pieces(), 2);
    }
  }
}

}  // namespace
}  // namespace kerf::cut
