// The hard cases of cutting, with every count that follows from the request alone. Each is cut on several sheets, which
// are turned, scaled and moved together with the curve.
#include <cstdio>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "tests/audit/audited_cut.h"
#include "tests/cut/calls.h"
#include "tests/cut/hard_cases.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

// A similarity, from cells to metres.
struct Motion {
  double scale = 1.0 / kCells;
  double angle = 0.0;
  Vector2d shift{0.0, 0.0};

  [[nodiscard]] Vector2d operator()(const Vector2d& p) const {
    return scale * (Vector2d(std::cos(angle) * p.x() - std::sin(angle) * p.y(),
                             std::sin(angle) * p.x() + std::cos(angle) * p.y()) +
                    shift);
  }
  [[nodiscard]] Curve operator()(Curve curve) const {
    if (auto* line = std::get_if<Polyline>(&curve)) {
      for (Vector2d& p : line->points) p = (*this)(p);
    } else if (auto* bezier = std::get_if<CubicBezier>(&curve)) {
      for (Vector2d& p : bezier->points) p = (*this)(p);
    } else if (auto* circle = std::get_if<Circle>(&curve)) {
      circle->centre = (*this)(circle->centre);
      circle->radius *= scale;
    }
    return curve;
  }
};

Motion random_motion(SeededRandom& random) {
  Motion motion;
  motion.scale = std::pow(10.0, random.uniform(-4.0, 1.5));
  motion.angle = random.uniform(0.0, 6.28);
  motion.shift = Vector2d(random.uniform(-40.0, 40.0), random.uniform(-40.0, 40.0));
  return motion;
}

// Sheets in cells.
enum class Kind { kGrid, kJittered, kHoled, kComponents, kCurved };
constexpr std::array<Kind, 5> kKinds{Kind::kGrid, Kind::kJittered, Kind::kHoled, Kind::kComponents, Kind::kCurved};

void append_grid(mesh::IndexedMesh& arrays, const Vector2d& corner, int width, int height) {
  const Eigen::Index first = arrays.rest.cols();
  arrays.rest.conservativeResize(2, first + (width + 1) * (height + 1));
  Eigen::Index at = first;
  for (int j = 0; j <= height; ++j) {
    for (int i = 0; i <= width; ++i) arrays.rest.col(at++) = corner + Vector2d(i, j);
  }
  const auto vertex = [&](int i, int j) { return static_cast<int>(first) + j * (width + 1) + i; };
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      const Eigen::Index t = arrays.triangles.cols();
      arrays.triangles.conservativeResize(3, t + 2);
      arrays.triangles.col(t) = Eigen::Vector3i(vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1));
      arrays.triangles.col(t + 1) = Eigen::Vector3i(vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1));
    }
  }
}

// Cells that the sheet with holes lacks.
bool is_hole(int i, int j) {
  return (i == 1 && j >= 9 && j <= 10) || (i >= 9 && i <= 10 && j == 1);
}

mesh::IndexedMesh arrays_of(Kind kind) {
  mesh::IndexedMesh arrays;
  arrays.rest.resize(2, 0);
  arrays.triangles.resize(3, 0);
  if (kind == Kind::kJittered) {
    const mesh::TriangleMesh jittered =
        test::must(mesh::make_jittered_grid({kCells + 1, kCells + 1, double{kCells}, double{kCells}}, 7));
    arrays.rest.resize(2, jittered.num_vertices());
    for (mesh::VertexId v = 0; v < jittered.num_vertices(); ++v) arrays.rest.col(v) = jittered.rest_position(v);
    arrays.triangles.resize(3, jittered.num_solid_triangles());
    for (mesh::TriangleId t = 0; t < jittered.num_solid_triangles(); ++t) {
      for (int k = 0; k < 3; ++k) arrays.triangles(k, t) = jittered.vertices(t)[static_cast<std::size_t>(k)];
    }
    return arrays;
  }
  append_grid(arrays, {0.0, 0.0}, kCells, kCells);
  if (kind == Kind::kHoled) {
    Eigen::Index kept = 0;
    for (int cell = 0; cell < kCells * kCells; ++cell) {
      if (is_hole(cell % kCells, cell / kCells)) continue;
      for (int half = 0; half < 2; ++half) arrays.triangles.col(kept++) = arrays.triangles.col(2 * cell + half);
    }
    arrays.triangles.conservativeResize(3, kept);
  }
  if (kind == Kind::kComponents) {
    append_grid(arrays, {15.0, 1.0}, 3, 4);
    append_grid(arrays, {-9.0, -7.0}, 5, 2);
  }
  return arrays;
}

mesh::TriangleMesh sheet(Kind kind, const Motion& motion) {
  mesh::IndexedMesh arrays = arrays_of(kind);
  if (kind == Kind::kCurved) {  // a saddle, stretched along x
    arrays.surface.resize(3, arrays.rest.cols());
    for (Eigen::Index v = 0; v < arrays.rest.cols(); ++v) {
      const Vector2d p = arrays.rest.col(v);
      arrays.surface.col(v) = motion.scale * Eigen::Vector3d(1.3 * p.x(), p.y(), 0.05 * (p.x() - 6.0) * (p.y() - 5.0));
    }
  }
  for (Eigen::Index v = 0; v < arrays.rest.cols(); ++v) arrays.rest.col(v) = motion(Vector2d(arrays.rest.col(v)));
  return test::must(mesh::import_mesh(arrays));
}

audit::Census census_of(const mesh::TriangleMesh& mesh) {
  audit::Census census;
  EXPECT_EQ(audit::find_flaw(mesh, &census).value_or(""), "");
  return census;
}

// Cuts, audits each cut, and counts.
Counts run(const HardCase& item, Kind kind, const Motion& motion, const CutOptions& options) {
  mesh::TriangleMesh mesh = sheet(kind, motion);
  const audit::Census before = census_of(mesh);
  CutStatus last = CutStatus::kNoIntersection;
  for (std::size_t i = 0; i < item.curves.size(); ++i) {
    CutOptions own = options;
    if (item.width > 0.0 && i >= item.first_strip) {
      own.width_m = motion.scale * item.width;
      own.dash = item.dash;
      for (double& length : own.dash.lengths) length *= motion.scale;
    }
    const audit::AuditedCut done = audit::cut_and_audit(mesh, {motion(item.curves[i]), own, {}});
    EXPECT_EQ(done.flaw.value_or(""), "");
    EXPECT_EQ(done.reason, "");
    last = done.outcome.status;
  }
  EXPECT_EQ(last, item.last);
  const audit::Census after = census_of(mesh);
  Counts counts;
  counts.pieces = static_cast<int>(after.pieces - before.pieces);
  counts.loops = static_cast<int>(after.loops - before.loops);
  constexpr std::array<std::size_t, 4> kDegrees{1, 3, 4, 5};
  for (std::size_t i = 0; i < 4; ++i) counts.open[i] = static_cast<int>(after.points_by_degree[kDegrees[i]]);
  counts.vertices = static_cast<int>(after.vertices - before.vertices);
  counts.triangles = static_cast<int>(after.triangles - before.triangles);
  return counts;
}

std::string in_words(const Counts& c) {
  std::string words = "{" + std::to_string(c.pieces) + ", " + std::to_string(c.loops) + ", {";
  for (std::size_t i = 0; i < 4; ++i) words += (i == 0 ? "" : ", ") + std::to_string(c.open[i]);
  return words + "}, " + std::to_string(c.vertices) + ", " + std::to_string(c.triangles) + "}";
}

bool same_topology(const Counts& a, const Counts& b) {
  return a.pieces == b.pieces && a.loops == b.loops && a.open == b.open;
}

TEST(CutConformance, CountsOfHardCasesOnTheGrid) {
  for (const HardCase& item : hard_cases()) {
    const Counts counts = run(item, Kind::kGrid, {}, plain());
    EXPECT_EQ(in_words(counts), in_words(item.counts)) << item.name;
  }
}

TEST(CutConformance, CountsOfStripsOnTheGrid) {
  for (const HardCase& item : strip_cases()) {
    const Counts counts = run(item, Kind::kGrid, {}, plain());
    EXPECT_EQ(in_words(counts), in_words(item.counts)) << item.name;
  }
}

// Curves that leave the sheet are clipped to a box around it that does not turn with it, and spaced from there.
bool leaves_sheet(const HardCase& item) {
  for (const Curve& curve : item.curves) {
    const auto* line = std::get_if<Polyline>(&curve);
    if (line == nullptr) continue;
    for (const Vector2d& p : line->points) {
      if (p.minCoeff() < 0.0 || p.maxCoeff() > kCells) return true;
    }
  }
  return false;
}

class CutConformanceOfMoved : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(EverySheet, CutConformanceOfMoved, testing::ValuesIn(kKinds));

// Moving sheet and curve together changes nothing that is counted, but where a curve is clipped; relaxing and refining
// change nothing but the number of vertices and triangles; and on the other sheets, away from what makes them
// different, the topology is the same.
TEST_P(CutConformanceOfMoved, CountsHoldUnderRigidMotionsAndScales) {
  const Kind kind = GetParam();
  SeededRandom random(31 + 100 * static_cast<std::uint64_t>(kind));
  for (const HardCase& item : hard_cases()) {
    const Counts expected = run(item, kind, {}, plain());
    EXPECT_TRUE(same_topology(expected, item.counts)) << item.name << " " << in_words(expected);
    for (int trial = 0; trial < kPlacements / 4 && !testing::Test::HasFailure(); ++trial) {
      SCOPED_TRACE(std::string(item.name) + ", placement " + std::to_string(trial));
      const bool is_plain = trial % 2 == 0;
      const Counts counts = run(item, kind, random_motion(random), is_plain ? plain() : CutOptions{});
      // On a curved sheet chords of circles, which do not turn with it, meet edges that no flip takes out of their way.
      if (is_plain && !leaves_sheet(item) && kind != Kind::kCurved) {
        EXPECT_EQ(in_words(counts), in_words(expected));
      } else {
        EXPECT_TRUE(same_topology(counts, expected)) << in_words(counts) << " for " << in_words(expected);
      }
    }
  }
}

// The sides of strips are rounded at their ends by chords that do not turn with the sheet.
TEST(CutConformance, CountsOfStripsHoldUnderRigidMotionsAndScalesOnEverySheet) {
  SeededRandom random(35);
  for (const HardCase& item : strip_cases()) {
    for (int trial = 0; trial < kPlacements && !testing::Test::HasFailure(); ++trial) {
      SCOPED_TRACE(std::string(item.name) + ", placement " + std::to_string(trial));
      const Kind kind = kKinds[static_cast<std::size_t>(trial) % kKinds.size()];
      const Motion motion = trial < 4 ? Motion{} : random_motion(random);
      const Counts counts = run(item, kind, motion, trial % 8 < 4 ? plain() : CutOptions{});
      EXPECT_TRUE(same_topology(counts, item.counts)) << in_words(counts) << " for " << in_words(item.counts);
    }
  }
}

TEST(CutConformance, CountsOfCutsAcrossHolesAndComponents) {
  struct Item {
    HardCase cut;
    Kind kind;
  };
  const std::vector<Item> items{
      {{"hole to border", {cells({{1.4, 9.6}, {1.7, 13}})}, {0, -1, {0, 2, 0, 0}, 0, 0}}, Kind::kHoled},
      {{"hole to inside", {cells({{1.4, 9.6}, {4.7, 6.3}})}, {0, 0, {1, 1, 0, 0}, 0, 0}}, Kind::kHoled},
      {{"hole to hole", {cells({{1.4, 9.6}, {10.3, 1.6}})}, {0, -1, {0, 2, 0, 0}, 0, 0}}, Kind::kHoled},
      {{"border to border across both holes", {cells({{-1, 11.7}, {13, -0.4}})}, {1, -1, {0, 6, 0, 0}, 0, 0}},
       Kind::kHoled},
      {{"ring round a hole", {Circle{{9.95, 1.55}, 1.4}}, {1, 2, {0, 0, 0, 0}, 0, 0}}, Kind::kHoled},
      {{"punch across a hole", {Circle{{9.95, 2.45}, 1.1}}, {1, 1, {0, 2, 0, 0}, 0, 0}}, Kind::kHoled},
      {{"along the sides of a hole", {cells({{2, 7.5}, {2, 11.5}})}, {0, 0, {2, 2, 0, 0}, 0, 0}}, Kind::kHoled},
      {{"across all components", {cells({{-10, -6.5}, {20, 6}})}, {3, 3, {0, 6, 0, 0}, 0, 0}}, Kind::kComponents},
      {{"from one into another", {cells({{7.3, 2.2}, {16.6, 3.3}})}, {0, 0, {2, 2, 0, 0}, 0, 0}}, Kind::kComponents},
      {{"between components", {cells({{13.5, -3}, {13.7, 14}})}, {}, CutStatus::kNoIntersection}, Kind::kComponents},
      {{"round a component", {Circle{{16.5, 3}, 5.2}}, {1, 1, {0, 2, 0, 0}, 0, 0}}, Kind::kComponents},
  };
  SeededRandom random(32);
  for (const Item& item : items) {
    for (int trial = 0; trial < kPlacements && !testing::Test::HasFailure(); ++trial) {
      SCOPED_TRACE(std::string(item.cut.name) + ", placement " + std::to_string(trial));
      const Motion motion = trial == 0 ? Motion{} : random_motion(random);
      const Counts counts = run(item.cut, item.kind, motion, trial % 2 == 0 ? plain() : CutOptions{});
      EXPECT_TRUE(same_topology(counts, item.cut.counts)) << in_words(counts);
    }
  }
}

// Pins are on the path and beside it: on it they are doubled, beside it they stay while others are relaxed.
TEST(CutConformance, FixedVerticesOnThePathStayWhereTheyAre) {
  SeededRandom random(33);
  for (int trial = 0; trial < kPlacements && !testing::Test::HasFailure(); ++trial) {
    SCOPED_TRACE("placement " + std::to_string(trial));
    const Motion motion = random_motion(random);
    mesh::TriangleMesh mesh = sheet(trial % 2 == 0 ? Kind::kGrid : Kind::kJittered, motion);
    std::vector<mesh::VertexId> fixed;
    for (mesh::VertexId v = 3; v < mesh.num_vertices(); v += 3) fixed.push_back(v);
    // Through a vertex that is fixed, and past others.
    const mesh::VertexId middle = fixed[fixed.size() / 2];
    const Vector2d at = mesh.rest_position(middle);
    const Vector2d along = motion.scale * Vector2d(2.3, 1.9);
    CutOptions options;
    options.min_angle_deg = 25.0;  // moves more of what is free
    const audit::AuditedCut done = audit::cut_and_audit(mesh, {Polyline{{at - along, at, at + along}}, options, fixed});
    EXPECT_EQ(done.flaw.value_or(""), "");
    EXPECT_GT(done.outcome.edit.moved_vertices.size(), 0U);
    const auto& added = done.outcome.edit.added_vertices;
    EXPECT_EQ(
        std::count_if(added.begin(), added.end(),
                      [middle](const mesh::VertexSource& s) { return s.sources[0] == middle && s.weights[0] == 1; }),
        1);
  }
}

// Loops smaller than the snap distance vanish, and the reply says so; larger ones are pieces.
TEST(CutConformance, DustIsMergedAndReportedOrIsAPiece) {
  SeededRandom random(34);
  for (int trial = 0; trial < kPlacements && !testing::Test::HasFailure(); ++trial) {
    SCOPED_TRACE("placement " + std::to_string(trial));
    const Motion motion = random_motion(random);
    for (const double size : {3e-4, 1e-2}) {
      mesh::TriangleMesh mesh = sheet(Kind::kGrid, motion);
      const Vector2d at(6.3, 5.6);
      const Curve curve =
          cells({{3.3, 5.4}, at, at + size * Vector2d(1, 0.2), at + size * Vector2d(0.3, 1), at, {8.6, 6.3}});
      const audit::AuditedCut done = audit::cut_and_audit(mesh, {motion(curve), {}, {}});
      EXPECT_EQ(done.flaw.value_or(""), "");
      EXPECT_EQ(mesh.num_pieces(), size < 1e-3 ? 1 : 2);
      EXPECT_EQ(done.outcome.report.merged_segments > 0, size < 1e-3);
    }
  }
}

}  // namespace
}  // namespace kerf::cut
