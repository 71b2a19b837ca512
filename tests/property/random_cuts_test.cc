// 20,000 random cuts, every invariant checked after each. A failure prints the seed of its trial; run that one alone
// with
//   KERF_CUT_SEED=<seed> random_cuts_test
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/cut/cut.h"
#include "server/mesh/grid_mesh.h"
#include "tests/cut/cut_checks.h"
#include "tests/support/meshes.h"

#ifndef KERF_RANDOM_CUTS
#define KERF_RANDOM_CUTS 20000
#endif

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

constexpr int kCutsOfASequence = 40;

Vector2d random_point(SeededRandom& random, double margin) {
  return {random.uniform(-margin, 1.0 + margin), random.uniform(-margin, 1.0 + margin)};
}

Vector2d random_vertex(SeededRandom& random, const mesh::TriangleMesh& mesh) {
  return mesh.rest_position(static_cast<mesh::VertexId>(random.below(static_cast<std::uint64_t>(mesh.num_vertices()))));
}

Vector2d polar(double angle, double radius) {
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

Curve random_bezier(SeededRandom& random) {
  CubicBezier bezier;
  const std::uint64_t pieces = 1 + random.below(3);
  for (std::uint64_t i = 0; i < 3 * pieces + 1; ++i) bezier.points.push_back(random_point(random, 0.3));
  return bezier;
}

// Winds or jumps about: crosses itself, and single elements many times over where `size` is small.
Curve random_scribble(SeededRandom& random, double size) {
  Polyline line;
  const Vector2d middle = random_point(random, 0.0);
  const std::uint64_t count = 2 + random.below(12);
  for (std::uint64_t i = 0; i < count; ++i) {
    line.points.push_back(middle + polar(random.uniform(0.0, 2.0 * std::numbers::pi), size * random.uniform()));
  }
  if (random.below(3) == 0) line.points.push_back(line.points.front());
  return line;
}

Curve random_spiral(SeededRandom& random) {
  Polyline line;
  const Vector2d middle = random_point(random, -0.2);
  const double reach = random.uniform(0.02, 0.4);
  const double turns = random.uniform(0.5, 3.0);
  for (int i = 0; i <= 60; ++i) line.points.push_back(middle + polar(turns * 0.1 * i, reach * i / 60.0));
  return line;
}

Curve random_wave(SeededRandom& random) {
  Polyline line;
  const Vector2d a = random_point(random, 0.1);
  const Vector2d b = random_point(random, 0.1);
  const Vector2d across = random.uniform(0.001, 0.1) * Vector2d(a.y() - b.y(), b.x() - a.x());
  const std::uint64_t waves = 2 + random.below(30);
  for (std::uint64_t i = 0; i <= waves; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(waves);
    line.points.push_back(a + t * (b - a) + (i % 2 == 0 ? 1.0 : -1.0) * across);
  }
  return line;
}

Curve random_hairpin(SeededRandom& random) {
  const Vector2d a = random_point(random, 0.1);
  const Vector2d b = random_point(random, 0.1);
  const double gap = std::pow(10.0, random.uniform(-9.0, -1.0));
  return Polyline{{a, b, a + Vector2d(gap, gap)}};
}

// Through vertices of the mesh as it is: along edges where they are neighbours.
Curve random_vertex_path(SeededRandom& random, const mesh::TriangleMesh& mesh) {
  Polyline line{{random_vertex(random, mesh), random_vertex(random, mesh)}};
  if (random.below(2) == 0) {
    auto vertex = static_cast<mesh::VertexId>(random.below(static_cast<std::uint64_t>(mesh.num_vertices())));
    line.points.assign(1, mesh.rest_position(vertex));
    const std::uint64_t steps = 1 + random.below(6);
    for (std::uint64_t i = 0; i < steps; ++i) {
      const std::vector<mesh::VertexId> ring = test::one_ring(mesh, vertex);
      vertex = ring[random.below(ring.size())];
      line.points.push_back(mesh.rest_position(vertex));
    }
  }
  return line;
}

Curve random_tiny(SeededRandom& random, const mesh::TriangleMesh& mesh) {
  const double size = std::pow(10.0, random.uniform(-12.0, -3.0));
  const Vector2d at = random.below(2) == 0 ? random_point(random, 0.0) : random_vertex(random, mesh);
  if (random.below(2) == 0) return Circle{at, size};
  return Polyline{{at, at + size * Vector2d(1.0, 0.3), at + size * Vector2d(-0.2, 1.0)}};
}

// Along grid lines, as one draws with snapping on.
Curve random_grid_line(SeededRandom& random) {
  const double at = static_cast<double>(random.below(11)) / 10.0;
  const double from = random.uniform(-0.2, 1.0);
  const double to = random.uniform(0.0, 1.2);
  if (random.below(2) == 0) return Polyline{{{from, at}, {to, at}}};
  return Polyline{{{at, from}, {at, to}}};
}

Curve shifted(const Curve& curve, const Vector2d& by) {
  Curve result = curve;
  if (auto* circle = std::get_if<Circle>(&result)) circle->centre += by;
  if (auto* line = std::get_if<Polyline>(&result)) {
    for (Vector2d& point : line->points) point += by;
  }
  if (auto* bezier = std::get_if<CubicBezier>(&result)) {
    for (Vector2d& point : bezier->points) point += by;
  }
  return result;
}

Curve random_curve(SeededRandom& random, const mesh::TriangleMesh& mesh, const std::vector<Curve>& earlier) {
  if (!earlier.empty() && random.below(5) == 0) {
    const Curve& old = earlier[random.below(earlier.size())];
    if (random.below(2) == 0) return old;
    const double offset = std::pow(10.0, random.uniform(-14.0, -1.5));
    return shifted(old, polar(random.uniform(0.0, 6.28), offset));
  }
  switch (random.below(11)) {
    case 0:
    case 1:
      return random_bezier(random);
    case 2:
      return random_scribble(random, 0.7);
    case 3:
      return random_scribble(random, 0.03);
    case 4:
      return random_spiral(random);
    case 5:
      return random_wave(random);
    case 6:
      return random_hairpin(random);
    case 7:
      return random_vertex_path(random, mesh);
    case 8:
      return random_tiny(random, mesh);
    case 9:
      return random_grid_line(random);
    default:
      return Circle{random_point(random, 0.1), std::pow(10.0, random.uniform(-3.0, -0.4))};
  }
}

mesh::TriangleMesh random_sheet(SeededRandom& random) {
  // One in four is coarse: a cut then reaches the border, and the rim of the domain, within an edge length or two.
  const bool is_coarse = random.below(4) == 0;
  const auto side = [&] { return static_cast<std::int32_t>(is_coarse ? 2 + random.below(3) : 8 + random.below(13)); };
  const std::int32_t num_x = side();
  const mesh::GridConfig config{num_x, side(), 1.0, 1.0};
  auto made = random.below(2) == 0 ? mesh::make_grid(config) : mesh::make_jittered_grid(config, random.next());
  return *made;
}

CutOptions random_options(SeededRandom& random) {
  CutOptions options;
  if (random.below(4) == 0) options.min_angle_deg = 0.0;
  if (random.below(4) == 0) options.relax = false;
  if (random.below(8) == 0) options.tolerance = std::pow(10.0, random.uniform(-3.0, -1.0));
  options.max_new_triangles = 30'000;
  return options;
}

struct Tally {
  int cuts = 0, applied = 0, missed = 0, refused = 0, undone = 0, degenerate = 0, stopped = 0;
};

// One cut on `mesh`, checked. False ends a sequence (a refusal: the sheet is full).
void cut_once(mesh::TriangleMesh& mesh, const CutRequest& request, Tally& tally) {
  ++tally.cuts;
  const mesh::TriangleMesh before = mesh;
  const Result<CutPlan> planned = plan(mesh, request);
  if (!planned.ok()) {
    ASSERT_EQ(planned.error().reason, "CURVE_DEGENERATE");
    ++tally.degenerate;
    return;
  }
  const Result<CutOutcome> outcome = apply(mesh, *planned);
  if (!outcome.ok()) {
    ++tally.refused;
    EXPECT_TRUE(outcome.error().reason == "CUT_ELEMENT_BUDGET" || outcome.error().reason == "CUT_NOT_REPRESENTABLE");
    ASSERT_TRUE(mesh == before) << "a refused cut changed the mesh";
    return;
  }
  if (outcome->status == CutStatus::kNoIntersection) {
    ++tally.missed;
    ASSERT_TRUE(mesh == before) << "a missed cut changed the mesh";
    ASSERT_TRUE(outcome->edit.empty());
    return;
  }
  ++tally.applied;
  if (outcome->report.refinement_stopped) ++tally.stopped;
  const auto violation = find_cut_violation(before, mesh, *outcome);
  ASSERT_FALSE(violation.has_value()) << *violation;
  if (tally.cuts % 8 == 0) {
    const auto uncovered = find_uncovered_path(mesh, *planned, outcome->report);
    ASSERT_FALSE(uncovered.has_value()) << *uncovered;
  }
  if (tally.cuts % 16 == 0) {
    mesh::TriangleMesh undone = mesh;
    outcome->undo.undo(undone);
    ASSERT_TRUE(undone == before) << "undo is not bit-identical";
    ASSERT_EQ(undone.state_hash(), before.state_hash());
    ++tally.undone;
  }
}

// A trial: one cut on a fresh sheet, or a sequence on one. Its seed is all that it depends on.
void run_trial(std::uint64_t seed, int num_cuts, Tally& tally) {
  SCOPED_TRACE("KERF_CUT_SEED=" + std::to_string(seed) + " cuts " + std::to_string(num_cuts));
  SeededRandom random(seed);
  mesh::TriangleMesh mesh = random_sheet(random);
  std::vector<Curve> earlier;
  for (int i = 0; i < num_cuts && mesh.num_triangle_slots() < 12'000; ++i) {
    CutRequest request{random_curve(random, mesh, earlier), random_options(random), {}};
    if (random.below(4) == 0) request.fixed_vertices = {0, mesh.num_vertices() / 2};
    earlier.push_back(request.curve);
    cut_once(mesh, request, tally);
    if (::testing::Test::HasFatalFailure()) return;
  }
}

// Even seeds are singles, odd ones sequences.
int cuts_of(std::uint64_t seed) {
  return seed % 2 == 0 ? 1 : kCutsOfASequence;
}

TEST(RandomCuts, KeepEveryInvariant) {
  Tally tally;
  if (const char* only = std::getenv("KERF_CUT_SEED")) {
    const std::uint64_t seed = std::strtoull(only, nullptr, 10);
    run_trial(seed, cuts_of(seed), tally);
    return;
  }
  // Two thirds of the cuts are singles.
  std::uint64_t single = 2;
  std::uint64_t sequence = 1;
  while (tally.cuts < KERF_RANDOM_CUTS && !HasFatalFailure()) {
    for (int i = 0; i < 2 * kCutsOfASequence && !HasFatalFailure(); ++i, single += 2) run_trial(single, 1, tally);
    if (HasFatalFailure()) break;
    run_trial(sequence, kCutsOfASequence, tally);
    sequence += 2;
  }
  std::printf("%d cuts: %d applied, %d missed, %d refused, %d degenerate, %d undone, refinement stopped in %d\n",
              tally.cuts, tally.applied, tally.missed, tally.refused, tally.degenerate, tally.undone, tally.stopped);
  EXPECT_GT(tally.applied, tally.cuts * 3 / 5);
  EXPECT_LE(tally.refused, tally.cuts / 500);
  EXPECT_LE(tally.degenerate, tally.cuts / 100);
}

}  // namespace
}  // namespace kerf::cut
