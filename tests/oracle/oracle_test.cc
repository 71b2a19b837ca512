// Random cuts against the exact arrangement. A failure prints the seed of its trial; run that one alone with
//   KERF_CUT_SEED=<seed> oracle_test --gtest_filter=*<test>*
#include <cstdio>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/cut/cut.h"
#include "tests/audit/mesh_audit.h"
#include "tests/oracle/exact_arrangement.h"
#include "tests/property/random_curves.h"
#include "tests/property/random_sheets.h"

// Cuts of each of the two tests.
#ifndef KERF_ORACLE_CUTS
#define KERF_ORACLE_CUTS 12500
#endif

namespace kerf::oracle {
namespace {

constexpr int kCutsOfASheet = 6;

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

// Cuts one sheet a few times and hands each cut to `judge(expected, is, done)`.
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
    if (!snaps) plan->options.snap = 0.0;  // to the least that the lattice needs
    double clearance = kClear;
    const Outcome expected = exact_outcome(mesh, plan->strokes, &clearance);
    if (!snaps && clearance < kClear) {
      ++tally.skipped;
      continue;
    }
    ++tally.cuts;
    const Result<cut::CutOutcome> done = cut::apply(mesh, *plan);
    if (!done.ok()) {
      ++tally.refused;
      EXPECT_TRUE(done.error().reason == "CUT_ELEMENT_BUDGET" ||
                  (!snaps && done.error().reason == "CUT_NOT_REPRESENTABLE"));
      continue;
    }
    if (done->status == cut::CutStatus::kApplied) ++tally.applied;
    judge(expected, outcome_of(mesh), *done);
    if (::testing::Test::HasFailure()) return;
  }
}

template <typename Judge>
Tally run_all(std::uint64_t first_seed, bool snaps, const Judge& judge) {
  Tally tally;
  if (const char* only = std::getenv("KERF_CUT_SEED")) {
    run_trial(std::strtoull(only, nullptr, 10), snaps, tally, judge);
    return tally;
  }
  for (std::uint64_t seed = first_seed; tally.cuts < KERF_ORACLE_CUTS && !::testing::Test::HasFailure(); ++seed) {
    run_trial(seed, snaps, tally, judge);
  }
  return tally;
}

TEST(Oracle, AgreesWithoutSnapping) {
  const Tally tally = run_all(1, false, [](const Outcome& expected, const Outcome& is, const cut::CutOutcome&) {
    EXPECT_EQ(in_words(is), in_words(expected));
  });
  EXPECT_LE(tally.refused, tally.cuts / 1000);
  std::printf("%d cuts, %d applied, %d refused; %d left out, in which something is nearer than %g lattice units\n",
              tally.cuts, tally.applied, tally.refused, tally.skipped, kClear);
}

// A gap closed, dust merged, or lips retraced within the snap distance, which leaves nothing to cut.
TEST(Oracle, DiffersWithSnappingOnlyWhereTheReplySaysSo) {
  int differ = 0, gaps = 0, dust = 0, retraced = 0;
  const auto judge = [&](const Outcome& expected, const Outcome& is, const cut::CutOutcome& done) {
    if (is == expected) return;
    ++differ;
    if (done.report.closed_gaps > 0) ++gaps;
    if (done.report.merged_segments > 0) ++dust;
    const bool is_retraced = done.status == cut::CutStatus::kNoIntersection;
    if (is_retraced) ++retraced;
    EXPECT_TRUE(done.report.closed_gaps > 0 || done.report.merged_segments > 0 || is_retraced)
        << in_words(is) << " for " << in_words(expected);
  };
  const Tally tally = run_all(1'000'001, true, judge);
  std::printf("%d cuts, %d applied, %d refused; %d differ: %d closed gaps, %d merged dust, %d retraced lips\n",
              tally.cuts, tally.applied, tally.refused, differ, gaps, dust, retraced);
}

}  // namespace
}  // namespace kerf::oracle
