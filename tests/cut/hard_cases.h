#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "server/core/cut/cut.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "server/core/mesh/build/mesh_import.h"
#include "tests/support/meshes.h"

// The hard cases of cutting on sheets of 12 x 12 cells, in cells: sheets and curves that are moved together, so that
// nothing may change but the rounding.
namespace kerf::cut {

inline constexpr int kCells = 12;

// Expected results of the cuts of a case. Vertices and triangles are those added on the regular grid with neither
// relaxation nor refinement.
struct Counts {
  int pieces = 0;           // more than before
  int loops = 0;            // more than before
  std::array<int, 4> open;  // points where 1 (tips), 3, 4, 5 or more open edges meet
  int vertices = 0;
  int triangles = 0;
  friend bool operator==(const Counts&, const Counts&) = default;
};

struct HardCase {
  const char* name;
  std::vector<Curve> curves;  // cut one after the other
  Counts counts;
  CutStatus last = CutStatus::kApplied;
  // For the last cut, or for those after `first_strip`.  cells
  double width = 0.0;
  std::size_t first_strip = 0;
  DashPattern dash = {};
};

inline Curve cells(std::vector<Eigen::Vector2d> points) {
  return Polyline{std::move(points)};
}

// A zigzag across the edge from (5, 5) to (5, 6) that crosses it `count` times.
inline Curve across_one_edge(int count) {
  Polyline line;
  for (int i = 0; i <= count; ++i) line.points.emplace_back(i % 2 == 0 ? 4.8 : 5.2, 5.12 + 0.76 * i / count);
  return line;
}

inline Curve spiral_in_cells() {
  Polyline line;
  for (int i = 0; i <= 60; ++i) {
    const double angle = 6.0 * std::numbers::pi * i / 60.0 + 0.1;
    line.points.emplace_back(6.1 + 0.05 * i * std::cos(angle), 5.9 + 0.05 * i * std::sin(angle));
  }
  return line;
}

inline std::vector<Curve> star_in_cells(int arms) {
  std::vector<Curve> curves;
  for (int i = 0; i < arms; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / arms + 0.3;
    curves.push_back(cells({{6.3, 5.8}, {6.3 + 2.6 * std::cos(angle), 5.8 + 2.6 * std::sin(angle)}}));
  }
  return curves;
}

inline std::vector<Curve> comb_in_cells(int teeth) {
  std::vector<Curve> curves{cells({{3.3, 4.6}, {8.7, 4.6}})};
  for (int i = 0; i < teeth; ++i) {
    const double x = 3.6 + 4.8 * i / (teeth - 1);
    curves.push_back(cells({{x, 4.6}, {x, 7.4}}));
  }
  return curves;
}

inline std::vector<HardCase> hard_cases() {
  const Curve slit = cells({{3.3, 5.4}, {8.6, 6.3}});
  const Curve narrow = cells({{3.3, 5.4}, {8.6, 6.3}, {3.3, 5.4004}});
  const Curve wedge = cells({{3.3, 5.4}, {8.6, 6.3}, {3.3, 5.42}});
  const Curve level = cells({{3.0, 6.0}, {9.0, 6.0}});
  const Curve bezier = CubicBezier{{{3.2, 4.3}, {6.1, 9.2}, {6.2, 2.4}, {8.7, 7.1}}};
  std::vector<HardCase> cases{
      {"slit", {slit}, {0, 1, {2, 0, 0, 0}, 14, 16}},
      {"through a vertex", {cells({{3.3, 3.7}, {6.7, 6.3}})}, {0, 1, {2, 0, 0, 0}, 11, 12}},
      {"through vertices, along a row", {cells({{3.5, 5}, {6.5, 5}})}, {0, 1, {2, 0, 0, 0}, 5, 4}},
      {"along edges", {cells({{3, 5}, {8, 5}})}, {0, 1, {2, 0, 0, 0}, 4, 0}},
      {"along diagonals", {cells({{3, 3}, {8, 8}})}, {0, 1, {2, 0, 0, 0}, 4, 0}},
      {"along one edge", {cells({{4, 5}, {5, 5}})}, {0, 1, {2, 0, 0, 0}, 2, 2}},
      {"part of one edge", {cells({{4.2, 5}, {4.7, 5}})}, {0, 1, {2, 0, 0, 0}, 4, 6}},
      {"tangent to an edge",
       {CubicBezier{{{3.6, 4.3}, {4.2, 5.2}, {4.7, 5.3}, {5.6, 4.1}}}},
       {0, 1, {2, 0, 0, 0}, 16, 18}},
      {"tangent to a row of edges", {Circle{{5.47, 6.5}, 1.5}}, {1, 2, {0, 0, 0, 0}, 48, 48}},
      {"ends on an edge", {cells({{3.2, 3.4}, {6.5, 6}})}, {0, 1, {2, 0, 0, 0}, 12, 14}},
      {"ends on a vertex", {cells({{3.2, 3.4}, {7, 6}})}, {0, 1, {2, 0, 0, 0}, 11, 12}},
      {"ends on the border", {cells({{5.3, 5.4}, {12, 6.2}})}, {0, 0, {1, 1, 0, 0}, 19, 19}},
      {"ends on a border vertex", {cells({{5.3, 5.4}, {12, 6}})}, {0, 0, {1, 1, 0, 0}, 18, 18}},
      {"border to inside", {cells({{-1, 5.5}, {5, 5.7}})}, {0, 0, {1, 1, 0, 0}, 15, 15}},
      {"border to border", {cells({{-1, 5.5}, {13, 6.7}})}, {1, 1, {0, 2, 0, 0}, 34, 32}},
      {"corner to corner", {cells({{0, 0}, {12, 12}})}, {1, 1, {0, 2, 0, 0}, 13, 0}},
      {"corner clipped", {cells({{-1, 2}, {2, -1}})}, {1, 1, {0, 2, 0, 0}, 4, 2}},
      {"inside one element", {cells({{4.55, 5.2}, {4.75, 5.3}})}, {0, 1, {2, 0, 0, 0}, 4, 6}},
      {"kinked inside one element",
       {cells({{4.55, 5.2}, {4.65, 5.4}, {4.7, 5.2}, {4.8, 5.4}})},
       {0, 1, {2, 0, 0, 0}, 6, 8}},
      {"closed inside one element",
       {cells({{4.55, 5.2}, {4.75, 5.25}, {4.7, 5.4}, {4.55, 5.2}})},
       {1, 2, {0, 0, 0, 0}, 6, 6}},
      {"loop touching the border", {cells({{0, 5}, {2.5, 4.1}, {2.6, 6.2}, {0, 5}})}, {1, 1, {0, 0, 1, 0}, 22, 20}},
      {"loop with a side on the border",
       {cells({{0, 4}, {2.5, 4.1}, {2.6, 6.2}, {0, 6}, {0, 4}})},
       {1, 1, {0, 2, 0, 0}, 22, 20}},
      {"loop touching a slit", {level, cells({{6.2, 6}, {7, 8}, {5, 8}, {6.2, 6}})}, {1, 2, {2, 0, 1, 0}, 20, 10}},
      {"element re-entered",
       {cells({{4.6, 5.3}, {5.3, 5.2}, {5.4, 4.7}, {4.6, 4.6}, {4.7, 5.2}})},
       {0, 1, {2, 0, 0, 0}, 10, 12}},
      {"figure 8", {cells({{3.4, 4.2}, {8.5, 7.8}, {8.4, 4.3}, {3.6, 7.7}, {3.4, 4.2}})}, {2, 3, {0, 0, 1, 0}, 55, 52}},
      {"loop with tails", {cells({{3.6, 3.6}, {7.2, 7.3}, {4.8, 7.8}, {7.7, 4.2}})}, {1, 2, {2, 0, 1, 0}, 38, 38}},
      {"there and back", {cells({{3.25, 5.5}, {8.75, 6.5}, {4.35, 5.7}})}, {0, 1, {2, 0, 0, 0}, 17, 18}},
      {"spiral", {spiral_in_cells()}, {0, 1, {2, 0, 0, 0}, 138, 140}},
      {"comb", comb_in_cells(6), {0, 1, {8, 6, 0, 0}, 74, 76}},
      {"T", {level, cells({{6.3, 6}, {6.9, 9.1}})}, {0, 1, {3, 1, 0, 0}, 15, 10}},
      {"T, short of the slit by less than the snap distance",
       {level, cells({{6.3, 6.0004}, {6.9, 9.1}})},
       {0, 1, {3, 1, 0, 0}, 15, 10}},
      {"X", {slit, cells({{6.3, 3.2}, {6.9, 9.1}})}, {0, 1, {4, 0, 1, 0}, 32, 34}},
      {"X of sheets' width",
       {cells({{-1, 5.5}, {13, 6.7}}), cells({{5.5, -1}, {6.7, 13}})},
       {3, 3, {0, 4, 1, 0}, 70, 64}},
      {"star of 7", star_in_cells(7), {0, 1, {7, 0, 0, 1}, 56, 58}},
      {"hash",
       {cells({{5.2, 3.3}, {5.3, 8.7}}), cells({{6.8, 3.3}, {6.9, 8.7}}), cells({{3.3, 5.2}, {8.7, 5.1}}),
        cells({{3.3, 6.7}, {8.7, 6.9}})},
       {1, 2, {8, 0, 4, 0}, 64, 64}},
      {"same cut twice", {slit, slit}, {0, 1, {2, 0, 0, 0}, 14, 16}, CutStatus::kNoIntersection},
      {"same bezier twice", {bezier, bezier}, {0, 1, {2, 0, 0, 0}, 45, 46}, CutStatus::kNoIntersection},
      {"beside a slit, closer than the snap distance",
       {slit, cells({{3.3, 5.4004}, {8.6, 6.3004}})},
       {0, 1, {2, 0, 0, 0}, 14, 16},
       CutStatus::kNoIntersection},
      {"there and back, closer than the snap distance", {narrow}, {0, 1, {2, 0, 0, 0}, 14, 16}},
      {"the same twice", {narrow, narrow}, {0, 1, {2, 0, 0, 0}, 14, 16}, CutStatus::kNoIntersection},
      {"there and back, closer at the turn only", {wedge}, {0, 1, {2, 0, 0, 0}, 28, 30}},
      {"that twice", {wedge, wedge}, {0, 1, {2, 0, 0, 0}, 28, 30}, CutStatus::kNoIntersection},
      {"that after a cross cut",
       {wedge, cells({{6.3, 3.2}, {6.9, 9.1}}), wedge},
       {1, 2, {4, 0, 2, 0}, 50, 50},
       CutStatus::kNoIntersection},
      {"part of it again, backwards",
       {slit, cells({{8.6, 6.3}, {3.3, 5.4}})},
       {0, 1, {2, 0, 0, 0}, 14, 16},
       CutStatus::kNoIntersection},
      {"half overlapping", {level, cells({{5.5, 6}, {10.5, 6}})}, {0, 1, {2, 0, 0, 0}, 10, 4}},
      {"along a lip, then off", {level, cells({{4, 6}, {6.5, 6}, {7.2, 8.3}})}, {0, 1, {3, 1, 0, 0}, 15, 10}},
      {"slit end to slit end",
       {cells({{3.3, 5.4}, {6, 6}}), cells({{6, 6}, {8.3, 5.2}})},
       {0, 1, {2, 0, 0, 0}, 15, 16}},
      {"closing a U",
       {cells({{4.3, 8.3}, {4.2, 4.3}, {7.7, 4.4}, {7.8, 8.4}}), cells({{3.6, 7.3}, {8.5, 7.4}})},
       {1, 2, {4, 0, 2, 0}, 52, 52}},
      {"from a slit out", {level, cells({{6.1, 6}, {6.3, 14}})}, {0, 0, {2, 2, 0, 0}, 24, 17}},
      {"leaves and comes back", {cells({{4, 4.5}, {-2, 5}, {-2, 7}, {4, 7.5}})}, {0, 0, {2, 2, 0, 0}, 26, 26}},
      {"one-triangle island", {cells({{5, 5}, {6, 5}, {6, 6}, {5, 5}})}, {1, 2, {0, 0, 0, 0}, 3, 0}},
      {"dust larger than the snap distance",
       {level, cells({{6.2, 6}, {6.21, 6.01}, {6.19, 6.01}, {6.2, 6}})},
       {1, 2, {2, 0, 1, 0}, 13, 6}},
      {"coincident control points",
       {cells({{3.3, 6}, {3.3, 6}, {6, 7.1}, {6, 7.1}, {8.6, 5.9}})},
       {0, 1, {2, 0, 0, 0}, 16, 18}},
      {"coincident control points, bezier",
       {CubicBezier{{{3.3, 5.4}, {3.3, 5.4}, {8.6, 6.3}, {8.6, 6.3}}}},
       {0, 1, {2, 0, 0, 0}, 30, 32}},
      {"collinear control points",
       {CubicBezier{{{3.3, 5.4}, {5.06, 5.7}, {6.83, 6.0}, {8.6, 6.3}}}},
       {0, 1, {2, 0, 0, 0}, 14, 16}},
      {"collinear and back",
       {CubicBezier{{{3.3, 5.4}, {11.25, 6.75}, {0.65, 4.95}, {8.6, 6.3}}}},
       {0, 1, {2, 0, 0, 0}, 52, 54}},
      {"cusp", {CubicBezier{{{4.2, 4.8}, {7.8, 8.4}, {4.2, 8.4}, {7.8, 4.8}}}}, {0, 1, {2, 0, 0, 0}, 36, 38}},
      {"bezier with a loop",
       {CubicBezier{{{4.2, 4.3}, {9.8, 8.9}, {2.2, 8.8}, {7.8, 4.2}}}},
       {1, 2, {2, 0, 1, 0}, 56, 56}},
      {"punch", {Circle{{6.1, 5.9}, 2.3}}, {1, 2, {0, 0, 0, 0}, 64, 64}},
      {"punch in a punch", {Circle{{6.1, 5.9}, 2.9}, Circle{{6.3, 5.8}, 1.2}}, {2, 4, {0, 0, 0, 0}, 112, 112}},
      {"along the border", {cells({{0, 2}, {0, 9}})}, {}, CutStatus::kNoIntersection},
      {"outside", {Circle{{60.0, 20.0}, 3.0}}, {}, CutStatus::kNoIntersection},
  };
  static const std::array<const char*, 8> kNames{
      "an edge crossed 2 times", "an edge crossed 3 times", "an edge crossed 4 times", "an edge crossed 5 times",
      "an edge crossed 6 times", "an edge crossed 7 times", "an edge crossed 8 times", "an edge crossed 9 times"};
  for (int count = 2; count <= 9; ++count) {
    // `count` - 1 corners, which are doubled, and two tips.
    const Counts counts{0, 1, {2, 0, 0, 0}, 2 * count, 2 * count + 2};
    cases.push_back({kNames[static_cast<std::size_t>(count - 2)], {across_one_edge(count)}, counts});
  }
  return cases;
}

// Cuts with a width. A lip that ends in the side of a strip meets two border edges there.
inline std::vector<HardCase> strip_cases() {
  constexpr CutStatus kApplied = CutStatus::kApplied;
  constexpr CutStatus kMissed = CutStatus::kNoIntersection;
  const Curve slit = cells({{3.3, 5.4}, {8.6, 6.3}});
  const Curve level = cells({{3.0, 6.0}, {9.0, 6.0}});
  const Curve cross = cells({{6.3, 3.2}, {6.9, 9.1}});
  const Curve square = cells({{4.2, 4.3}, {7.8, 4.4}, {7.7, 7.6}, {4.3, 7.7}, {4.2, 4.3}});
  return {
      {"strip inside", {slit}, {0, 1, {0, 0, 0, 0}, 32, 32}, kApplied, 0.3},
      {"strip narrower than an element", {slit}, {0, 1, {0, 0, 0, 0}, 28, 30}, kApplied, 0.02},
      {"strip inside one element", {cells({{4.55, 5.2}, {4.75, 5.3}})}, {0, 1, {0, 0, 0, 0}, 16, 18}, kApplied, 0.05},
      {"strip as wide as three elements", {slit}, {0, 1, {0, 0, 0, 0}, 55, 32}, kApplied, 3.0},
      {"strip along edges", {cells({{3, 5}, {8, 5}})}, {0, 1, {0, 0, 0, 0}, 28, 24}, kApplied, 0.3},
      {"strip whose sides run along edges", {cells({{3, 5.5}, {8, 5.5}})}, {0, 1, {0, 0, 0, 0}, 36, 26}, kApplied, 1.0},
      {"strip over the border", {cells({{-1, 5.5}, {5, 5.7}})}, {0, 0, {0, 0, 0, 0}, 25, 25}, kApplied, 0.3},
      {"strip along the border", {cells({{0, 2}, {0, 9}})}, {0, 0, {0, 0, 0, 0}, 13, 13}, kApplied, 0.3},
      {"strip from border to border", {cells({{-1, 5.5}, {13, 6.7}})}, {1, 1, {0, 0, 0, 0}, 31, 26}, kApplied, 0.3},
      {"strip that clips a corner", {cells({{-1, 2}, {2, -1}})}, {1, 1, {0, 0, 0, 0}, 7, 5}, kApplied, 0.3},
      {"strip across an older lip", {level, cross}, {0, 1, {2, 2, 0, 0}, 42, 36}, kApplied, 0.3, 1},
      {"strip along an older lip", {level, level}, {0, 1, {0, 0, 0, 0}, 21, 16}, kApplied, 0.3, 1},
      {"strip along half of an older lip",
       {level, cells({{6, 6}, {9, 6}})},
       {0, 1, {1, 1, 0, 0}, 24, 19},
       kApplied,
       0.3,
       1},
      {"strip that ends at an older lip",
       {level, cells({{6.3, 6}, {6.9, 9.1}})},
       {0, 1, {2, 2, 0, 0}, 36, 30},
       kApplied,
       0.3,
       1},
      {"ring strip", {Circle{{6.1, 5.9}, 2.3}}, {1, 2, {0, 0, 0, 0}, 70, 60}, kApplied, 0.4},
      {"ring strip without an inside", {Circle{{6.1, 5.9}, 0.4}}, {0, 1, {0, 0, 0, 0}, 32, 33}, kApplied, 1.0},
      {"square strip", {square}, {1, 2, {0, 0, 0, 0}, 57, 57}, kApplied, 0.3},
      {"strip that crosses itself",
       {cells({{3.6, 3.6}, {7.2, 7.3}, {4.8, 7.8}, {7.7, 4.2}})},
       {1, 2, {0, 0, 0, 0}, 63, 58},
       kApplied,
       0.3},
      {"strips that leave an island",
       {cells({{5.2, 3.3}, {5.3, 8.7}}), cells({{6.8, 3.3}, {6.9, 8.7}}), cells({{3.3, 5.2}, {8.7, 5.1}}),
        cells({{3.3, 6.7}, {8.7, 6.9}})},
       {1, 2, {0, 0, 0, 0}, 147, 140},
       kApplied,
       0.3},
      {"strips that cross", {slit, cross}, {0, 1, {0, 0, 0, 0}, 70, 69}, kApplied, 0.3},
      {"strip twice", {slit, slit}, {0, 1, {0, 0, 0, 0}, 32, 32}, kMissed, 0.3},
      {"ring strip twice",
       {Circle{{6.1, 5.9}, 2.3}, Circle{{6.1, 5.9}, 2.3}},
       {1, 2, {0, 0, 0, 0}, 70, 60},
       kMissed,
       0.4},
      {"dashes with a width", {level}, {0, 3, {0, 0, 0, 0}, 66, 66}, kApplied, 0.3, 0, {{1.0, 1.0}, 0.0}},
      {"dashes that run into each other", {level}, {0, 1, {0, 0, 0, 0}, 70, 65}, kApplied, 0.4, 0, {{1.0, 0.2}, 0.0}},
      {"dashes over the border",
       {cells({{-0.5, 5.6}, {12.5, 5.7}})},
       {0, 5, {0, 0, 0, 0}, 148, 158},
       kApplied,
       0.3,
       0,
       {{1.0, 1.0}, 0.0}},
      {"strip outside", {Circle{{60.0, 20.0}, 3.0}}, {}, kMissed, 0.3},
  };
}

}  // namespace kerf::cut
