// Random cuts against the exact arrangement, in four parts of one binary. A failure prints the seed of its trial; run
// that one alone with
//   KERF_CUT_SEED=<seed> oracle_tests --gtest_filter='*<test>/0'
#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/cut/cut.h"
#include "tests/audit/mesh_audit.h"
#include "tests/audit/path_audit.h"
#include "tests/oracle/exact_arrangement.h"
#include "tests/property/random_curves.h"
#include "tests/property/random_sheets.h"
#include "tests/support/trials.h"

namespace kerf::oracle {
namespace {

constexpr int kCutsOfASheet = 6;
constexpr int kParts = 4;
constexpr std::uint64_t kSeedsOfAPart = 1'000'000;

// Lattice units; without snapping, cuts in which something comes nearer than this to something else are left out:
// points are rounded.
constexpr double kClear = 256.0;

Outcome outcome_of(const mesh::TriangleMesh& mesh) {
  audit::Census census;
  EXPECT_EQ(audit::find_flaw(mesh, &census).value_or(""), "");
  return {
      census.pieces,
      census.characteristic(),
      {census.points_by_degree[1], census.points_by_degree[3], census.points_by_degree[4], census.points_by_degree[5]}};
}

std::string in_words(const Outcome& o) {
  std::string words = std::to_string(o.pieces) + " pieces, characteristic " + std::to_string(o.characteristic);
  for (const std::int64_t count : o.places) words += ", " + std::to_string(count);
  return words;
}

struct Tally {
  int cuts = 0, applied = 0, skipped = 0, refused = 0;
};

// Holds the result of a cut, and the expected one.
struct Case {
  Outcome expected, is;
  const cut::CutReport& report;
  double clearance_m = 0.0;  // m; how near two things come to each other that do not touch, where less than twice that:
  double snap_m = 0.0;       // m; the largest snap distance
};

// Cuts one sheet a few times and hands each cut to `judge`.
template <typename Judge>
void run_trial(std::uint64_t seed, bool snaps, Tally& tally, const Judge& judge) {
  SCOPED_TRACE("KERF_CUT_SEED=" + std::to_string(seed));
  SeededRandom random(seed);
  const property::RandomArrays made = property::random_arrays(random);
  mesh::TriangleMesh mesh = test::must(mesh::import_mesh(made.arrays));
  std::vector<cut::Curve> earlier;
  for (int i = 0; i < kCutsOfASheet && mesh.num_triangle_slots() < 3000; ++i) {
    cut::CutOptions options;
    if (random.below(4) != 0) options.min_angle_deg = 0.0;
    if (random.below(4) != 0) options.relax = false;
    earlier.push_back(property::random_curve(random, mesh, made.frame, earlier));
    Result<cut::CutPlan> plan = cut::plan(mesh, {earlier.back(), options, {}});
    if (!plan.ok()) continue;
    if (!snaps) plan->snap = 0.0;  // to the least that the lattice needs
    const double snap = audit::largest_snap(mesh, *plan);
    const double spacing = mesh.lattice().spacing;
    double clearance = snaps ? 2.0 * snap / spacing : kClear;
    const Outcome expected = exact_outcome(mesh, plan->strokes, clearance);
    if (!snaps && clearance < kClear) {
      ++tally.skipped;
      continue;
    }
    const Result<cut::CutOutcome> done = cut::apply(mesh, *plan);
    if (!done.ok()) {
      ++tally.refused;
      EXPECT_TRUE(done.error().reason == "CUT_ELEMENT_BUDGET" ||
                  (!snaps && done.error().reason == "CUT_NOT_REPRESENTABLE"));
      continue;
    }
    ++tally.cuts;
    if (done->status == cut::CutStatus::kApplied) ++tally.applied;
    judge(Case{expected, outcome_of(mesh), done->report, clearance * spacing, snap});
    if (::testing::Test::HasFailure()) return;
  }
}

template <typename Judge>
Tally run_all(std::uint64_t first_seed, bool snaps, const Judge& judge) {
  Tally tally;
  if (const auto only = test::only_seed()) {
    run_trial(*only, snaps, tally, judge);
    return tally;
  }
  // A share of 2 % needs 1,500 cuts.
  const int num_cuts = test::num_trials({.few = 1'500, .usual = 3'000, .many = 12'500});
  for (std::uint64_t seed = first_seed; tally.cuts < num_cuts && !::testing::Test::HasFailure(); ++seed) {
    run_trial(seed, snaps, tally, judge);
  }
  return tally;
}

class Oracle : public ::testing::TestWithParam<int> {
 protected:
  // Both tests have their own.
  [[nodiscard]] static std::uint64_t first_seed(bool snaps) {
    return test::first_seed() + 1 + (2 * static_cast<std::uint64_t>(GetParam()) + (snaps ? 1 : 0)) * kSeedsOfAPart;
  }
};

TEST_P(Oracle, AgreesWithoutSnapping) {
  const Tally tally =
      run_all(first_seed(false), false, [](const Case& c) { EXPECT_EQ(in_words(c.is), in_words(c.expected)); });
  EXPECT_LE(tally.refused, tally.cuts / 1000);
  std::printf(
      "%d cuts agree, %d applied; %d refused, %d left out, in which something is nearer than %g lattice units\n",
      tally.cuts, tally.applied, tally.refused, tally.skipped, kClear);
}

// If the two differ, the reply reports gaps closed or dust merged, and for gaps the widest. There must also be
// something narrower than two places can be moved towards each other. Exceptions are the few trials with strands that
// cross at so small an angle that their crossing moves farther.
TEST_P(Oracle, DiffersWithSnappingOnlyWhereTheReplySaysSo) {
  int differ = 0, gaps = 0, dust = 0, shallow = 0;
  const auto judge = [&](const Case& c) {
    EXPECT_LE(c.report.widest_gap_m, c.snap_m);
    EXPECT_EQ(c.report.closed_gaps > 0, c.report.widest_gap_m > 0.0);
    if (c.is == c.expected) return;
    ++differ;
    if (c.report.closed_gaps > 0) ++gaps;
    if (c.report.merged_segments > 0) ++dust;
    EXPECT_TRUE(c.report.closed_gaps > 0 || c.report.merged_segments > 0)
        << in_words(c.is) << " for " << in_words(c.expected);
    if (c.clearance_m >= 2.0 * c.snap_m) ++shallow;
  };
  const Tally tally = run_all(first_seed(true), true, judge);
  EXPECT_EQ(tally.refused, 0);
  EXPECT_LE(shallow, differ / 50);
  std::printf(
      "%d cuts, %d applied; %d differ: %d with closed gaps, %d with merged dust; %d with all twice as far apart\n",
      tally.cuts, tally.applied, differ, gaps, dust, shallow);
}

INSTANTIATE_TEST_SUITE_P(Part, Oracle, ::testing::Range(0, kParts));

}  // namespace
}  // namespace kerf::oracle
