// Thousands of random cuts against the quality contract. No new triangle has an angle below the one asked for, or half
// of it near strands, or is flatter than that makes it. Exceptions are the corners named in the report, and cuts of
// which it says that refinement stopped. Heights are as large as the curves leave room for. Most random curves leave
// little: a strand may lie close to another one, an older lip, a corner of a path or the border. A triangle in between
// is no higher than their distance, which the exact arrangement gives. A failure prints the seed of its trial; run that
// one alone with
//   KERF_CUT_SEED=<seed> property_tests --gtest_filter='RandomCutQuality.*'
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/cut/cut.h"
#include "tests/oracle/exact_arrangement.h"
#include "tests/property/random_curves.h"
#include "tests/property/random_sheets.h"
#include "tests/support/trials.h"

namespace kerf::cut {
namespace {

constexpr int kCutsOfASequence = 4;

// Longest edge / shortest height where no angle is below 20 degrees: at most 2 / tan(20 degrees).
constexpr double kMaxAspect = 5.5;

// The median of the smallest height is at least this where there is room.  -, edge lengths
constexpr double kRoomyHeight = 0.15;

// In the medians below gaps this wide leave room for the heights asked for.  -, edge lengths
constexpr double kRoomy = 0.1;

struct Tally {
  int cuts = 0, applied = 0, stopped = 0;
  int stopped_with_room = 0;                         // where nothing is nearer to anything else than kRoomy
  std::int64_t crossed = 0, added = 0, corners = 0;  // of those asked for 20 degrees
  std::vector<double> heights;                       // smallest height of each cut, edge lengths
  std::vector<double>
      share_of_room;          // the same over the room: the least distance of two things, an edge length at most
  std::vector<double> roomy;  // the first, where the room is at least kRoomy
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Cuts with room whose smallest height is at least this. Where that is half of all or more, it is at most the median.
std::ptrdiff_t num_roomy_from(double height, const Tally& tally) {
  return std::count_if(tally.roomy.begin(), tally.roomy.end(), [=](double each) { return each >= height; });
}

// Three standard deviations of how many of n random values lie above their distribution's median. Trials that are the
// same every time have no scatter.
double scatter(std::size_t n) {
  return test::chosen_seed() == 0 ? 0.0 : 1.5 * std::sqrt(static_cast<double>(n));
}

// `room`: edge lengths.
void count(const CutReport& report, double edge_length, double room, bool is_fine, Tally& tally) {
  ++tally.applied;
  tally.corners += report.quality.num_corners;
  if (!is_fine) {
    tally.crossed += report.crossed_triangles;
    tally.added += report.new_triangles;
  }
  const double height = report.quality.min_height_m / edge_length;
  tally.heights.push_back(height);
  tally.share_of_room.push_back(height / room);
  if (room >= kRoomy) tally.roomy.push_back(height);
  if (report.refinement_stopped) {
    ++tally.stopped;
    if (room >= kRoomy) ++tally.stopped_with_room;
    return;
  }
  EXPECT_EQ(report.quality.triangles_below_contract, 0);
  const CutQuality& quality = report.quality;
  if (quality.triangles_below_angle == 0) {
    EXPECT_LE(quality.max_aspect, kMaxAspect);
  } else if (quality.num_corners == 0) {
    const double asked = is_fine ? kFineMinAngle : CutOptions{}.min_angle_deg;
    EXPECT_GE(quality.elsewhere_min_angle_deg, asked - 1e-6);
    EXPECT_GE(quality.strands.min_angle_deg, kStrandAngle * asked - 1e-6);
  }
}

// A single cut or a few one after the other, on a sheet of good triangles: what is bad is the cuts' doing.
void run_trial(std::uint64_t seed, Tally& tally) {
  SCOPED_TRACE("KERF_CUT_SEED=" + std::to_string(seed));
  SeededRandom random(seed);
  const auto side = static_cast<std::int32_t>(8 + random.below(20));
  const mesh::GridConfig config{side, side, 1.0, 1.0};
  mesh::TriangleMesh mesh =
      random.below(2) == 0 ? mesh::make_grid(config).value() : mesh::make_jittered_grid(config, random.next()).value();
  std::vector<Curve> earlier;
  for (int i = 0; i < (seed % 2 == 0 ? 1 : kCutsOfASequence); ++i) {
    CutRequest request{property::random_curve(random, mesh, {}, earlier), {}, {}};
    earlier.push_back(request.curve);
    const bool is_fine = random.below(4) == 0;
    if (is_fine) request.options.min_angle_deg = kFineMinAngle;
    ++tally.cuts;
    const Result<CutPlan> planned = plan(mesh, request);
    if (!planned.ok()) continue;
    const double edge_length = mesh.base_edge_length();
    const double unit = mesh.lattice().spacing / edge_length;
    double clearance = 1.0 / unit;
    oracle::exact_outcome(mesh, planned->strokes, clearance);
    const Result<CutOutcome> outcome = apply(mesh, *planned);
    if (outcome.ok() && outcome->status == CutStatus::kApplied) {
      count(outcome->report, edge_length, clearance * unit, is_fine, tally);
    }
  }
}

TEST(RandomCutQuality, NoTriangleBelowTheAngleOutsideTheCornersNamed) {
  Tally tally;
  if (const auto only = test::only_seed()) {
    run_trial(*only, tally);
    return;
  }
  const int num_cuts = test::num_trials({.few = 1'000, .usual = 3'000, .many = 12'000});
  for (std::uint64_t seed = test::first_seed() + 1; tally.cuts < num_cuts && !HasFailure(); ++seed)
    run_trial(seed, tally);
  const double per_crossed = static_cast<double>(tally.added) / static_cast<double>(tally.crossed);
  std::printf(
      "%d cuts: %d applied, refinement stopped in %d; %.2f new a crossed triangle at 20 degrees; medians of the "
      "smallest "
      "height, edge lengths: %.3f, where there is room (%d cuts) %.3f, of the room %.2f; %lld corners\n",
      tally.cuts, tally.applied, tally.stopped, per_crossed, median(tally.heights),
      static_cast<int>(tally.roomy.size()), median(tally.roomy), median(tally.share_of_room),
      static_cast<long long>(tally.corners));
  EXPECT_LE(per_crossed, 4.0);
  EXPECT_GE(static_cast<double>(num_roomy_from(kRoomyHeight, tally)),
            0.5 * static_cast<double>(tally.roomy.size()) - scatter(tally.roomy.size()));
  EXPECT_GE(median(tally.share_of_room), 0.9);
  // A third of the curves are scribbles, hairpins and repetitions with a small offset, whose narrow gaps needles span.
  EXPECT_LE(tally.stopped, tally.applied / 200);
  EXPECT_EQ(tally.stopped_with_room, 0);
}

}  // namespace
}  // namespace kerf::cut
