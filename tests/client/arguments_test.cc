#include "client/cli/arguments.h"

#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "client/cli/output.h"
#include "kerf/v1/sheets.pb.h"

namespace kerf::cli {
namespace {

template <typename T>
bool refused(const Parsed<T>& parsed) {
  return std::holds_alternative<UsageError>(parsed);
}

TEST(Arguments, GridsAndSizes) {
  const GridSize grid = std::get<GridSize>(parse_grid("50x40"));
  EXPECT_EQ(grid.columns, 50);
  EXPECT_EQ(grid.rows, 40);
  const SheetSize size = std::get<SheetSize>(parse_size("1.5x0.25"));
  EXPECT_EQ(size.width, 1.5);
  EXPECT_EQ(size.height, 0.25);
  for (const char* bad : {"", "x", "50", "50x", "x50", "50x50x50", "a x b", "50.5x2", "50 x50", "5e400x3"}) {
    EXPECT_TRUE(refused(parse_grid(bad))) << bad;
  }
  EXPECT_TRUE(refused(parse_image_size("99999999999x2")));
}

TEST(Arguments, Points) {
  const auto points = std::get<std::vector<v1::Vec2>>(parse_points(" 0.2,0.5  -1e-3,nan "));
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points[0].x(), 0.2);
  EXPECT_EQ(points[1].x(), -1e-3);
  EXPECT_TRUE(std::isnan(points[1].y()));
  for (const char* bad : {"", "  ", "1", "1,2,3", "1,", ",1", "1;2", "1,2 3", "0x1,2", "1, 2"}) {
    EXPECT_TRUE(refused(parse_points(bad))) << bad;
  }
}

TEST(Arguments, Circles) {
  const v1::Circle circle = std::get<v1::Circle>(parse_circle("0.5,0.25,0.1"));
  EXPECT_EQ(circle.center().y(), 0.25);
  EXPECT_EQ(circle.radius_m(), 0.1);
  for (const char* bad : {"", "1,2", "1,2,3,4", "1,2,x", "1,2,3 "}) EXPECT_TRUE(refused(parse_circle(bad))) << bad;
}

TEST(Output, JsonForScriptsHasNumbersAndSnakeCase) {
  v1::ListSheetsResponse list;
  v1::Sheet& sheet = *list.add_sheets();
  sheet.set_name("sheets/a");
  sheet.set_tick(1234567890123);
  sheet.add_pinned_vertices(7);
  const std::string json = to_script_json(list, -1);
  EXPECT_NE(json.find("\"tick\":1234567890123"), std::string::npos) << json;
  EXPECT_NE(json.find("\"pinned_vertices\":[7]"), std::string::npos) << json;
  EXPECT_NE(json.find("\"overruns\":0"), std::string::npos) << json;
  EXPECT_NE(json.find("\"next_page_token\":\"\""), std::string::npos) << json;
}

}  // namespace
}  // namespace kerf::cli
