// The `d` of a path element.

#include "server/service/svg/path_data.h"

#include <numbers>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

namespace kerf::svg {
namespace {

using Eigen::Vector2d;
using Points = std::vector<Vector2d>;

constexpr std::size_t kPlenty = 1000;

// The whole, which must be readable.
std::vector<cut::Subpath> parsed(const std::string& text) {
  PathData data = parse_path_data(text, kPlenty);
  EXPECT_EQ(data.error, "") << text;
  return data.subpaths;
}

Vector2d end_of(const cut::Segment& segment) {
  return std::visit([](const auto& each) { return each.end; }, segment);
}

// Start and ends of the only subpath.
Points corners(const std::string& text) {
  const std::vector<cut::Subpath> subpaths = parsed(text);
  EXPECT_EQ(subpaths.size(), 1U) << text;
  if (subpaths.empty()) return {};
  Points points{subpaths[0].start};
  for (const cut::Segment& segment : subpaths[0].segments) points.push_back(end_of(segment));
  return points;
}

TEST(SvgPathData, LinesAbsoluteAndRelative) {
  const Points expected{{1, 2}, {3, 4}, {5, 4}, {5, 7}};
  EXPECT_EQ(corners("M1 2L3 4H5V7"), expected);
  EXPECT_EQ(corners("m1 2l2 2h2v3"), expected);
  EXPECT_EQ(corners("M 1,2 L 3 , 4 \n H\t5 V 7 "), expected);
  EXPECT_EQ(corners("M1 2 3 4H5V6 7"), (Points{{1, 2}, {3, 4}, {5, 4}, {5, 6}, {5, 7}}));
  EXPECT_EQ(corners("m1 2 2 2 2 0 0 3"), expected);  // repeats of a moveto are linetos
  EXPECT_EQ(corners("M1 2h1 1 1"), (Points{{1, 2}, {2, 2}, {3, 2}, {4, 2}}));
}

TEST(SvgPathData, NumbersNeedNoMoreThanTheyMust) {
  EXPECT_EQ(corners("M1.5.5L-.5-.3"), (Points{{1.5, 0.5}, {-0.5, -0.3}}));
  EXPECT_EQ(corners("M1e1-2E-1L+3+4."), (Points{{10, -0.2}, {3, 4}}));
  EXPECT_EQ(corners("M.1.2.3.4"), (Points{{0.1, 0.2}, {0.3, 0.4}}));
  EXPECT_EQ(corners("M0-0L1e-999 2"), (Points{{0, 0}, {0, 2}}));
  EXPECT_EQ(corners("M007,08L1,1"), (Points{{7, 8}, {1, 1}}));
}

TEST(SvgPathData, CurvesAndTheirSmoothForms) {
  const auto segments = parsed("M0 0C1 2 3 2 4 0S7-2 8 0s3 2 4 0")[0].segments;
  ASSERT_EQ(segments.size(), 3U);
  const auto& second = std::get<cut::CubicTo>(segments[1]);
  EXPECT_EQ(second.controls[0], Vector2d(5, -2));  // 2 (4, 0) - (3, 2)
  EXPECT_EQ(second.controls[1], Vector2d(7, -2));
  const auto& third = std::get<cut::CubicTo>(segments[2]);
  EXPECT_EQ(third.controls[0], Vector2d(9, 2));
  EXPECT_EQ(third.controls[1], Vector2d(11, 2));
  EXPECT_EQ(third.end, Vector2d(12, 0));
  const auto quadratics = parsed("m1 1q1 2 2 0t2 0T7 1")[0].segments;
  EXPECT_EQ(std::get<cut::QuadraticTo>(quadratics[0]).control, Vector2d(2, 3));
  EXPECT_EQ(std::get<cut::QuadraticTo>(quadratics[1]).control, Vector2d(4, -1));
  EXPECT_EQ(std::get<cut::QuadraticTo>(quadratics[2]).control, Vector2d(6, 3));
  EXPECT_EQ(std::get<cut::QuadraticTo>(quadratics[2]).end, Vector2d(7, 1));
  // Without one of its own kind before it, the control point is where the pen is.
  EXPECT_EQ(std::get<cut::CubicTo>(parsed("M1 1S2 2 3 3")[0].segments[0]).controls[0], Vector2d(1, 1));
  EXPECT_EQ(std::get<cut::CubicTo>(parsed("M0 0Q1 1 2 0S2 2 3 3")[0].segments[1]).controls[0], Vector2d(2, 0));
  EXPECT_EQ(std::get<cut::QuadraticTo>(parsed("M0 0C1 1 2 2 3 0T5 5")[0].segments[1]).control, Vector2d(3, 0));
}

TEST(SvgPathData, ArcsWithCompactFlags) {
  for (const char* text : {"M0 0A5 4 30 1 0 6 7", "M0 0A5,4,30,1,0,6,7", "M0 0a5 4 30 106 7", "M0 0A5 4 30 1,06 7"}) {
    const auto arc = std::get<cut::ArcTo>(parsed(text)[0].segments.at(0));
    EXPECT_EQ(arc.semi_axes, Vector2d(5, 4)) << text;
    EXPECT_NEAR(arc.rotation, std::numbers::pi / 6, 1e-15);
    EXPECT_TRUE(arc.large);
    EXPECT_FALSE(arc.counter_clockwise);
    EXPECT_EQ(arc.end, Vector2d(6, 7));
  }
  const auto two = parsed("M0 0a1 1 0 01.5.5 1 1 0 11-1-1")[0].segments;
  ASSERT_EQ(two.size(), 2U);
  EXPECT_TRUE(std::get<cut::ArcTo>(two[0]).counter_clockwise);
  EXPECT_EQ(std::get<cut::ArcTo>(two[0]).end, Vector2d(0.5, 0.5));
  EXPECT_EQ(std::get<cut::ArcTo>(two[1]).end, Vector2d(-0.5, -0.5));
  EXPECT_TRUE(std::holds_alternative<cut::LineTo>(parsed("M0 0A0 4 0 0 0 1 1")[0].segments[0]));
  EXPECT_EQ(std::get<cut::ArcTo>(parsed("M0 0A-5-4 0 0 0 1 1")[0].segments[0]).semi_axes, Vector2d(5, 4));
}

TEST(SvgPathData, SubpathsCloseAndGoOn) {
  const auto subpaths = parsed("M0 0h1v1zl2 2M5 5zm1 1h1z");
  ASSERT_EQ(subpaths.size(), 3U);
  EXPECT_TRUE(subpaths[0].closed);
  EXPECT_EQ(subpaths[1].start, Vector2d(0, 0));  // after a closepath the pen is back at the start
  EXPECT_EQ(end_of(subpaths[1].segments[0]), Vector2d(2, 2));
  EXPECT_FALSE(subpaths[1].closed);
  EXPECT_EQ(subpaths[2].start, Vector2d(6, 6));  // relative to the subpath of one point, which draws nothing
  EXPECT_TRUE(parsed("").empty());
  EXPECT_TRUE(parsed("M 3 4").empty());
}

TEST(SvgPathData, DrawsUpToTheFirstError) {
  struct Case {
    std::string text;
    std::size_t segments;
    std::string error;
  };
  const std::vector<Case> cases{
      {"M0 0L1 1L2", 1, "byte 10"},         {"M0 0L1 1 2 2 3", 2, "number is missing"},
      {"M0 0L1 1X2 2", 1, "'X'"},           {"L1 1M0 0L1 1", 0, "moveto"},
      {"M0 0L1 1,L2 2", 1, "comma"},        {"M0 0C1 1 2 2 3 3 4 4", 1, "number is missing"},
      {"M0 0A1 1 0 2 0 3 3", 0, "'A'"},     {"M0 0L1,,1", 0, "'L'"},
      {"M0 0L1e999 1", 0, "'L'"},           {"M0 0L nan 1", 0, "'L'"},
      {"M0 0L1 1\xff", 1, "not a command"}, {"M", 0, "'M'"},
  };
  for (const Case& item : cases) {
    const PathData data = parse_path_data(item.text, kPlenty);
    EXPECT_NE(data.error.find(item.error), std::string::npos) << item.text << ": " << data.error;
    std::size_t segments = 0;
    for (const cut::Subpath& subpath : data.subpaths) segments += subpath.segments.size();
    EXPECT_EQ(segments, item.segments) << item.text;
  }
}

TEST(SvgPathData, StopsWhereThereIsTooMuch) {
  std::string text = "M0 0";
  for (int i = 0; i < 5000; ++i) text += " 1 1";
  EXPECT_EQ(parse_path_data(text, 100).subpaths.at(0).segments.size(), 101U);
}

}  // namespace
}  // namespace kerf::svg
