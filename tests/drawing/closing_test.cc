// Lines of drawings that together surround something.

#include "server/service/drawing/closing.h"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "server/core/cut/fit.h"
#include "server/service/drawing/arc_length.h"
#include "server/service/svg/path_data.h"

namespace kerf::drawing {
namespace {

cut::Path closed_path(const std::string& data) {
  svg::PathData parsed = svg::parse_path_data(data, 10'000);
  EXPECT_EQ(parsed.error, "");
  cut::Path path{std::move(parsed.subpaths)};
  close_lines(path);
  return path;
}
std::ptrdiff_t num_closed(const cut::Path& path) {
  return std::count_if(path.subpaths.begin(), path.subpaths.end(),
                       [](const cut::Subpath& each) { return each.closed; });
}
void expect_one_line(const std::string& data, double length) {
  const cut::Path path = closed_path(data);
  ASSERT_EQ(path.subpaths.size(), 1U) << data;
  EXPECT_TRUE(path.subpaths[0].closed) << data;
  EXPECT_NEAR(length_of(path.subpaths[0]), length, 1e-2 * length) << data;
}

TEST(DrawingClosing, LinesInAnyOrderAndDirectionBecomeOne) {
  expect_one_line("M0 0H9 M9 0V9 M9 9H0 M0 9V0", 36);
  expect_one_line("M9 9V0 M0 0H9 M0 9H9 M0 9V0", 36);
  expect_one_line("M0 0H9V9 M0 0V9H9", 36);
  // Ends that nearly meet, and one line that nearly comes back.
  expect_one_line("M0 0H9 M9.005 0V9 M9 9H0 M0 9.004V0", 36);
  expect_one_line("M0 0H9V9H0V0.005", 36);
  // Curves are led backwards, too.
  expect_one_line("M0 0C0 4 9 4 9 0 M0 0Q4 -9 9 0", 25.33);
  expect_one_line("M9 0C9 4 0 4 0 0 M0 0Q4 -9 9 0", 25.33);
}

TEST(DrawingClosing, EachFrameIsALineOfItsOwn) {
  const cut::Path frames = closed_path("M0 0H9 M20 0H29 M9 0V9H0 M29 0V9H20 M0 0V9 M20 0V9 M2 2H4V4Z");
  EXPECT_EQ(frames.subpaths.size(), 3U);
  EXPECT_EQ(num_closed(frames), 3);
}

TEST(DrawingClosing, WhatSurroundsNothingStays) {
  const cut::Path open = closed_path("M0 0H9V9 M20 0H29V9H20V1 M3 3H4V4Z");
  EXPECT_EQ(open.subpaths.size(), 3U);
  EXPECT_EQ(num_closed(open), 1);
  EXPECT_EQ(open.subpaths[0].segments.size(), 2U);
  // Marks of the box that is fitted come first, and stay.
  cut::Path marked{
      {{{0, 0}, {cut::QuadraticTo{{0, 0}, {0, 0}}}, false}, {{0, 0}, {cut::QuadraticTo{{0, 0}, {0, 0}}}, false}}};
  close_lines(marked);
  EXPECT_EQ(marked.subpaths.size(), 2U);
}

TEST(DrawingClosing, CopiesAreLeftOut) {
  EXPECT_EQ(closed_path("M0 0H9V9H0Z M20 0H29V9Z M0 0H9V9H0Z").subpaths.size(), 2U);
  expect_one_line("M0 0H9 M9 0H0 M9 0V9 M9 9H0 M9 9H0 M0 9V0", 36);
}

}  // namespace
}  // namespace kerf::drawing
