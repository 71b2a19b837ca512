#include "server/core/cut/outline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <polyclipping/clipper.hpp>

#include "server/base/random.h"
#include "server/core/cut/round_offset.h"
#include "server/core/cut/segment_distance.h"
#include "tests/support/trials.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

double distance(const Vector2d& p, const std::vector<Stroke>& strokes) {
  double least = std::numeric_limits<double>::infinity();
  for (const Stroke& stroke : strokes) {
    for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
      least = std::min(least, distance_to_segment(p, stroke.points[i], stroke.points[i + 1]));
    }
  }
  return least;
}

// Counts points at random near the strokes that the outline holds or leaves out wrongly.
int count_misplaced(const std::vector<Stroke>& strokes, double width, SeededRandom& random) {
  const FlatCurve curve{strokes, 0.0};
  const Result<Outline> strip = outline(curve, width, 0.005 * width);
  EXPECT_TRUE(strip.ok());
  if (!strip.ok()) return 1;
  const double radius = 0.5 * width;
  const double margin = strip->curve.deviation_m + 1e-9;
  int misplaced = 0;
  for (int i = 0; i < 300; ++i) {
    const std::vector<Vector2d>& points = strokes[random.below(strokes.size())].points;
    const Vector2d p =
        points[random.below(points.size())] + width * Vector2d(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    const double away = distance(p, strokes);
    const bool is_inside = contains(strip->curve.strokes, p);
    if (is_inside ? away > radius + margin : away < radius - margin) ++misplaced;
  }
  return misplaced;
}

std::vector<Vector2d> there_and_back(const std::vector<Vector2d>& there, const std::vector<Vector2d>& back) {
  std::vector<Vector2d> line = there;
  line.insert(line.end(), back.rbegin() + 1, back.rend());
  return line;
}

class OutlineOfRetracedLine : public testing::TestWithParam<bool> {
 protected:
  // A line of 2 to 5 chords, straight or not.
  std::vector<Vector2d> random_line(SeededRandom& random) const {
    const auto anywhere = [&] { return Vector2d(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)); };
    std::vector<Vector2d> line{anywhere()};
    Vector2d along = anywhere();
    const std::uint64_t chords = 2 + random.below(4);
    for (std::uint64_t i = 0; i < chords; ++i) {
      if (!GetParam()) along = anywhere();
      line.emplace_back(line.back() + along * random.uniform(0.02, 0.3));
    }
    return line;
  }
  SeededRandom random_{test::first_seed() + 1};
  const int trials_ = test::num_trials({.few = 50, .usual = 200, .many = 20'000});
};

TEST_P(OutlineOfRetracedLine, HasAllOfTheStripThereAndBack) {
  for (int i = 0; i < trials_; ++i) {
    const auto line = random_line(random_);
    EXPECT_EQ(count_misplaced({{there_and_back(line, line)}}, random_.uniform(0.01, 0.2), random_), 0) << i;
  }
}

TEST_P(OutlineOfRetracedLine, HasAllOfTheStripWhereOnlyAPartIsRetraced) {
  for (int i = 0; i < trials_; ++i) {
    const auto line = random_line(random_);
    auto retraced = there_and_back(line, line);
    retraced.pop_back();
    EXPECT_EQ(count_misplaced({{retraced}}, random_.uniform(0.01, 0.2), random_), 0) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(StraightAndBent, OutlineOfRetracedLine, testing::Bool());

TEST(Outline, HasAllOfTheStripOfAStraightLineDividedOtherwiseOnTheWayBack) {
  SeededRandom random(test::first_seed() + 1);
  for (int i = 0; i < test::num_trials({.few = 100, .usual = 400, .many = 20'000}); ++i) {
    const Vector2d a(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    const Vector2d b = a + Vector2d(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    const auto divided = [&](std::uint64_t parts) {
      std::vector<Vector2d> line;
      for (std::uint64_t k = 0; k <= parts; ++k) {
        line.emplace_back(a + (b - a) * (static_cast<double>(k) / static_cast<double>(parts)));
      }
      return line;
    };
    const auto line = there_and_back(divided(1 + random.below(40)), divided(1 + random.below(5)));
    EXPECT_EQ(count_misplaced({{line}}, random.uniform(0.01, 0.2), random), 0) << i;
  }
}

TEST(Outline, HasAllOfTheStripWhereStrokesShareChords) {
  SeededRandom random(test::first_seed() + 1);
  const std::vector<Vector2d> left{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
  const std::vector<Vector2d> right{{1, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 0}};
  const std::vector<Vector2d> from_a_side{{0.5, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}, {0.5, 0}};
  std::vector<Vector2d> twice = left;
  twice.insert(twice.end(), left.begin() + 1, left.end());
  const Stroke along{{{0.0, 0.3}, {1.0, 0.8}}}, over{{{0.5, 0.55}, {2.0, 1.3}}};
  const Stroke point{{{1.5, 0.2}, {1.5 + 1e-12, 0.2}}};
  const std::vector<std::vector<Stroke>> cases{{{left}, {right}},       {{twice}},     {{from_a_side}},
                                               {{from_a_side}, {left}}, {along, over}, {{left}, point}};
  for (std::size_t i = 0; i < cases.size(); ++i) {
    for (const double width : {0.01, 0.1, 0.4}) EXPECT_EQ(count_misplaced(cases[i], width, random), 0) << i;
  }
}

// Clipper's own offset takes its angles from the C library, whose last bits differ by processor.
TEST(RoundOffset, IsThatOfClipperUpToItsRounding) {
  const int trials = test::num_trials({20, 200, 5000});
  int equal = 0;
  for (int trial = 0; trial < trials; ++trial) {
    SeededRandom random(test::first_seed() + static_cast<std::uint64_t>(trial));
    ClipperLib::Path chain;
    const std::size_t size = 2 + random.below(8);
    while (chain.size() < size) chain.emplace_back(random.below(1'000'000), random.below(1'000'000));
    const bool is_closed = size > 2 && trial % 2 == 0;
    const double radius = std::pow(10.0, random.uniform(-1.0, 5.3));
    const double tolerance = radius * random.uniform(0.01, 0.3);

    ClipperLib::ClipperOffset clipper;
    clipper.ArcTolerance = tolerance;
    clipper.AddPath(chain, ClipperLib::jtRound, is_closed ? ClipperLib::etClosedLine : ClipperLib::etOpenRound);
    ClipperLib::Paths expected;
    clipper.Execute(expected, radius);
    RoundOffset offset(radius, tolerance);
    offset.add(chain, is_closed);
    const ClipperLib::Paths loops = offset.united();

    double area = 0.0, expected_area = 0.0;
    for (const ClipperLib::Path& loop : loops) area += ClipperLib::Area(loop);
    for (const ClipperLib::Path& loop : expected) expected_area += ClipperLib::Area(loop);
    EXPECT_NEAR(area, expected_area, 1e-5 * expected_area + 1e6) << "seed " << test::first_seed() << " + " << trial;
    equal += loops == expected ? 1 : 0;
  }
  EXPECT_GE(equal, trials * 9 / 10);
}

}  // namespace
}  // namespace kerf::cut
