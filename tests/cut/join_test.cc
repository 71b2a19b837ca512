// Ends of lines that nearly meet something: joined within a distance, or counted.

#include "server/core/cut/join.h"

#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/cut/chord_tree.h"
#include "server/core/cut/nearby_lips.h"
#include "server/core/cut/segment_distance.h"
#include "tests/cut/calls.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

Subpath line(const std::vector<Vector2d>& points) {
  Subpath subpath{points.front(), {}, false};
  for (std::size_t i = 1; i < points.size(); ++i) subpath.segments.emplace_back(LineTo{points[i]});
  return subpath;
}

// Cuts one copy of the mesh with the given distance, and returns what came of it.
CutReport cut_lines(mesh::TriangleMesh& mesh, const std::vector<std::vector<Vector2d>>& lines, double join) {
  Path path;
  for (const std::vector<Vector2d>& points : lines) path.subpaths.push_back(line(points));
  CutRequest request{path, {}, {}};
  if (join > 0.0) request.options.join_m = join;
  return apply(mesh, *plan(mesh, request))->report;
}
CutReport cut_lines(const std::vector<std::vector<Vector2d>>& lines, double join) {
  mesh::TriangleMesh mesh = grid(41);  // Edges of 25 mm.
  return cut_lines(mesh, lines, join);
}

// A square whose ends are `gap` apart.
std::vector<Vector2d> square(double gap) {
  return {{0.3, 0.3}, {0.7, 0.3}, {0.7, 0.7}, {0.3, 0.7}, {0.3, 0.3 + gap}};
}

TEST(CutJoin, ASquareWithAGapComesOut) {
  for (const double gap : {1e-5, 1e-4, 1e-3, 5e-3}) {
    const CutReport joined = cut_lines({square(gap)}, 6e-3);
    EXPECT_EQ(joined.pieces, 2) << gap;
    // The snap distance closes the narrowest gap without help.
    const bool snaps = gap < 2.5e-5;
    EXPECT_EQ(joined.joins.joined_ends, snaps ? 0 : 1) << gap;
    EXPECT_NEAR(joined.joins.widest_join_m, snaps ? 0.0 : gap, 1e-12);
    EXPECT_EQ(joined.joins.near_ends, 0) << gap;
  }
}

TEST(CutJoin, EndsLeftOpenAreCounted) {
  const CutReport open = cut_lines({square(1e-3)}, 0.0);
  EXPECT_EQ(open.pieces, 1);
  EXPECT_EQ(open.joins.near_ends, 2);
  EXPECT_NEAR(open.joins.nearest_end_m, 1e-3, 1e-12);
  EXPECT_EQ(open.joins.joined_ends, 0);
  // A tenth of the edge length is the limit.
  EXPECT_EQ(cut_lines({square(3e-3)}, 0.0).joins.near_ends, 0);
  EXPECT_EQ(cut_lines({square(2e-3)}, 1e-3).joins.near_ends, 2);
  EXPECT_EQ(cut_lines({square(2.5e-3)}, 0.0).joins.near_ends, 2);
  EXPECT_EQ(cut_lines({square(1e-3)}, 1e-3).pieces, 2);
}

TEST(CutJoin, EndsMeetLinesLipsAndTheBorder) {
  // A frame of four lines, each short of the next one, which they meet in its course.
  const std::vector<std::vector<Vector2d>> frame{{{0.2, 0.301}, {0.699, 0.301}},
                                                 {{0.7, 0.2}, {0.7, 0.699}},
                                                 {{0.8, 0.7}, {0.301, 0.7}},
                                                 {{0.3, 0.8}, {0.3, 0.302}}};
  EXPECT_EQ(cut_lines(frame, 0.0).pieces, 1);
  const CutReport joined = cut_lines(frame, 2e-3);
  EXPECT_EQ(joined.pieces, 2);
  EXPECT_EQ(joined.joins.joined_ends, 4);
  // From border to border, each end 1 mm short of it.
  EXPECT_EQ(cut_lines({{{0.001, 0.5}, {0.999, 0.6}}}, 2e-3).pieces, 2);
  EXPECT_EQ(cut_lines({{{0.001, 0.5}, {0.999, 0.6}}}, 0.0).joins.near_ends, 2);
  // One after another, to the lips of earlier cuts.
  mesh::TriangleMesh mesh = grid(41);
  cut_lines(mesh, {frame[0]}, 2e-3);
  cut_lines(mesh, {frame[1]}, 2e-3);
  cut_lines(mesh, {frame[2]}, 2e-3);
  const CutReport last = cut_lines(mesh, {frame[3]}, 2e-3);
  EXPECT_EQ(last.joins.joined_ends, 1);
  EXPECT_EQ(last.pieces, 1);  // The first line ended before there was a second one.
}

TEST(CutJoin, AKnifeThatMovesOnSeparates) {
  SeededRandom random(1);
  mesh::TriangleMesh mesh = grid(41);
  CutReport report;
  for (int i = 0; i < 60; ++i) {
    const auto at = [](int k) { return Vector2d(-0.01 + 1.02 * k / 60.0, 0.5 + 0.1 * std::sin(0.3 * k)); };
    const auto noise = [&random] { return 1e-4 * (static_cast<double>(random.below(2001)) / 1000.0 - 1.0); };
    report = cut_lines(mesh, {{at(i) + Vector2d(noise(), noise()), at(i + 1)}}, 5e-4);
    EXPECT_EQ(report.joins.near_ends, 0) << i;
  }
  EXPECT_EQ(report.pieces, 2);
}

TEST(CutJoin, WhatRunsOverIsNotJoined) {
  // A cross whose arms end 1 mm beyond each other, and a line that ends just beyond the border.
  const CutReport cross = cut_lines({{{0.3, 0.5}, {0.501, 0.5}}, {{0.5, 0.3}, {0.5, 0.501}}}, 5e-3);
  EXPECT_EQ(cross.joins.joined_ends, 0);
  EXPECT_EQ(cross.joins.near_ends, 0);
  EXPECT_EQ(cut_lines({{{-0.001, 0.5}, {0.5, 0.5}}}, 5e-3).joins.joined_ends, 0);
  // Lines that share a point, and closed lines.
  EXPECT_EQ(cut_lines({{{0.3, 0.5}, {0.5, 0.5}}, {{0.5, 0.5}, {0.5, 0.8}}}, 5e-3).joins.joined_ends, 0);
  EXPECT_EQ(cut_lines({{{0.3, 0.3}, {0.7, 0.3}, {0.7, 0.7}, {0.3, 0.3}}}, 5e-3).joins.joined_ends, 0);
  // No end is led on farther than half its line: dots stay dots.
  EXPECT_EQ(cut_lines({{{0.3, 0.5}, {0.8, 0.5}}, {{0.5, 0.504}, {0.502, 0.504}}}, 8e-3).joins.joined_ends, 0);
}

TEST(CutJoin, EndsOfDashesStay) {
  Path path;
  path.subpaths.push_back(line({{0.2, 0.5}, {0.3, 0.5}, {0.3, 0.5}}));
  path.subpaths.push_back(line({{0.301, 0.5}, {0.301, 0.5}, {0.4, 0.5}}));
  mesh::TriangleMesh mesh = grid(41);
  CutRequest request{path, {}, {}};
  request.options.join_m = 5e-3;
  const CutReport report = apply(mesh, *plan(mesh, request))->report;
  EXPECT_EQ(report.joins.joined_ends, 0);
  EXPECT_EQ(report.joins.near_ends, 0);
  EXPECT_EQ(kept_ends(path).size(), 2U);
}

TEST(CutJoin, NothingChangesWithoutIt) {
  // The report alone tells of near ends; the mesh is the same as without the search.
  mesh::TriangleMesh mesh = grid(41);
  CutRequest request{Path{{line(square(1e-3))}}, {}, {}};
  const CutPlan made = *plan(mesh, request);
  EXPECT_EQ(made.strokes.front().points.size(), 5U);
  EXPECT_EQ(made.joins.near_ends, 2);
}

// The search among chords against a look at all of them.
TEST(CutJoin, TheTreeFindsWhatIsNear) {
  SeededRandom random(7);
  const auto place = [&random]() -> Vector2d {
    return Vector2d(static_cast<double>(random.below(1000)), static_cast<double>(random.below(1000))) / 1000.0;
  };
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Stroke> strokes(1 + random.below(20));
    for (Stroke& stroke : strokes) {
      for (std::uint64_t i = 0; i < 2 + random.below(30); ++i) stroke.points.push_back(place());
    }
    const ChordTree tree(strokes);
    const Vector2d from = place();
    const double distance = 0.05;
    int found = 0;
    tree.for_each_near(Eigen::AlignedBox2d(from), distance, [&](const ChordTree::Chord& chord) {
      const std::vector<Vector2d>& points = strokes[static_cast<std::size_t>(chord.stroke)].points;
      const auto at = static_cast<std::size_t>(chord.index);
      found += distance_to_segment(from, points[at], points[at + 1]) <= distance ? 1 : 0;
      return true;
    });
    int expected = 0;
    for (const Stroke& stroke : strokes) {
      for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
        expected += distance_to_segment(from, stroke.points[i], stroke.points[i + 1]) <= distance ? 1 : 0;
      }
    }
    EXPECT_EQ(found, expected);
  }
}

// The work of a search depends on what is near, not on the size of the sheet.
TEST(CutJoin, TheSearchForLipsIsLocal) {
  for (const int vertices : {41, 401}) {
    const mesh::TriangleMesh mesh =
        *mesh::make_grid({vertices, vertices, 0.025 * (vertices - 1), 0.025 * (vertices - 1)});
    NearbyLips lips(mesh, 200);  // Few triangles are within three edge lengths.
    ASSERT_TRUE(lips.is_on_sheet({0.5, 0.03}));
    EXPECT_FALSE(lips.near({0.5, 0.03}, 0.075).empty()) << vertices;
    NearbyLips spent(mesh, 3);
    ASSERT_TRUE(spent.is_on_sheet({0.5, 0.03}));
    EXPECT_TRUE(spent.near({0.5, 0.03}, 0.075).empty());
  }
}

}  // namespace
}  // namespace kerf::cut
