// 20,000 random cuts, every invariant checked after each. A failure prints the seed of its trial; run that one alone
// with
//   KERF_CUT_SEED=<seed> random_cuts_test
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/cut/cut.h"
#include "tests/audit/audited_cut.h"
#include "tests/property/random_curves.h"
#include "tests/property/random_sheets.h"

#ifndef KERF_RANDOM_CUTS
#define KERF_RANDOM_CUTS 20000
#endif

namespace kerf::cut {
namespace {

using property::RandomSheet;

constexpr int kCutsOfASequence = 40;
constexpr int kSingles = 4;

RandomSheet random_sheet(SeededRandom& random) {
  if (random.below(2) == 0) {
    const mesh::GridConfig config = property::random_grid(random);
    return {random.below(2) == 0 ? mesh::make_grid(config).value()
                                 : mesh::make_jittered_grid(config, random.next()).value(),
            {}};
  }
  const property::RandomArrays made = property::random_arrays(random);
  Result<mesh::TriangleMesh> mesh = mesh::import_mesh(made.arrays);
  EXPECT_TRUE(mesh.ok()) << mesh.error().message;
  return {*mesh, made.frame};
}

CutOptions random_options(SeededRandom& random) {
  CutOptions options;
  if (random.below(4) == 0) options.min_angle_deg = 0.0;
  if (random.below(4) == 0) options.relax = false;
  if (random.below(8) == 0) options.tolerance = std::pow(10.0, random.uniform(-3.0, -1.0));
  if (random.below(5) == 0) {
    options.method = Method::kElement;
  } else if (random.below(8) == 0) {
    options.tip_edge_length_m = std::pow(10.0, random.uniform(-4.0, 0.0));
    options.tip_grading = random.uniform(1.2, 3.0);
  }
  options.max_new_triangles = 30'000;
  return options;
}

struct Tally {
  int cuts = 0, applied = 0, missed = 0, refused = 0, degenerate = 0, stopped = 0;
};

// One cut on `mesh`, checked.
void cut_once(mesh::TriangleMesh& mesh, const CutRequest& request, Tally& tally) {
  ++tally.cuts;
  audit::Depth depth;
  if (tally.cuts % 16 == 0) depth = audit::kDeepest;
  const audit::AuditedCut done = audit::cut_and_audit(mesh, request, depth);
  ASSERT_EQ(done.flaw.value_or(""), "");
  switch (done.end) {
    case audit::AuditedCut::End::kApplied:
      ++tally.applied;
      if (done.outcome.report.refinement_stopped) ++tally.stopped;
      ASSERT_LE(done.outcome.report.deviation_of_tolerance, 1.0);
      break;
    case audit::AuditedCut::End::kMissed:
      ++tally.missed;
      break;
    case audit::AuditedCut::End::kRefused:
      EXPECT_TRUE(done.reason == "CUT_ELEMENT_BUDGET" || done.reason == "TOLERANCE_NOT_KEPT") << done.reason;
      ++tally.refused;
      break;
    case audit::AuditedCut::End::kInvalid:
      ASSERT_EQ(done.reason, "CURVE_DEGENERATE");
      ++tally.degenerate;
      break;
  }
}

// A trial: a few single cuts, each on a copy of one sheet as built (even seeds), or a sequence of cuts (odd ones). Its
// seed is all that it depends on.
void run_trial(std::uint64_t seed, Tally& tally) {
  SCOPED_TRACE("KERF_CUT_SEED=" + std::to_string(seed));
  SeededRandom random(seed);
  const auto [built, frame] = random_sheet(random);
  const bool is_sequence = seed % 2 == 1;
  mesh::TriangleMesh mesh = built;
  std::vector<Curve> earlier;
  for (int i = 0; i < (is_sequence ? kCutsOfASequence : kSingles) && mesh.num_triangle_slots() < 4'000; ++i) {
    if (!is_sequence && i > 0) mesh = built;
    CutRequest request{property::random_curve(random, mesh, frame, earlier), random_options(random), {}};
    if (random.below(12) == 0) {
      const auto length = [&] { return frame.scale * random.uniform(0.01, 0.3); };
      request.options.dash = {{length(), length()}, length()};
    }
    if (random.below(4) == 0) request.fixed_vertices = {0, mesh.num_vertices() / 2};
    if (is_sequence) earlier.push_back(request.curve);
    cut_once(mesh, request, tally);
    if (::testing::Test::HasFatalFailure()) return;
  }
}

TEST(RandomCuts, KeepEveryInvariant) {
  Tally tally;
  if (const char* only = std::getenv("KERF_CUT_SEED")) {
    run_trial(std::strtoull(only, nullptr, 10), tally);
    return;
  }
  // Two thirds of the cuts are singles.
  std::uint64_t single = 2;
  std::uint64_t sequence = 1;
  while (tally.cuts < KERF_RANDOM_CUTS && !HasFatalFailure()) {
    for (int i = 0; i < 2 * kCutsOfASequence / kSingles && !HasFatalFailure(); ++i, single += 2) {
      run_trial(single, tally);
    }
    if (HasFatalFailure()) break;
    run_trial(sequence, tally);
    sequence += 2;
  }
  std::printf("%d cuts: %d applied, %d missed, %d refused, %d degenerate, refinement stopped in %d\n", tally.cuts,
              tally.applied, tally.missed, tally.refused, tally.degenerate, tally.stopped);
  EXPECT_GT(tally.applied, tally.cuts * 3 / 5);
  EXPECT_LE(tally.refused, tally.cuts / 500);
  EXPECT_LE(tally.degenerate, tally.cuts / 100);
}

}  // namespace
}  // namespace kerf::cut
