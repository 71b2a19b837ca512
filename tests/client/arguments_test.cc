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

TEST(Arguments, Vectors) {
  const v1::Vec3 vector = std::get<v1::Vec3>(parse_vector("-1,0.5,2e1"));
  EXPECT_EQ(vector.x(), -1.0);
  EXPECT_EQ(vector.y(), 0.5);
  EXPECT_EQ(vector.z(), 20.0);
  for (const char* bad : {"", "1,2", "1,2,3,4", "1,2,x", "1, 2,3"}) EXPECT_TRUE(refused(parse_vector(bad))) << bad;
}

TEST(Arguments, Regions) {
  EXPECT_EQ(std::get<v1::Region>(parse_region("top")).edge(), v1::Region::TOP);
  EXPECT_EQ(std::get<v1::Region>(parse_region("top-corners")).edge(), v1::Region::TOP_CORNERS);
  EXPECT_TRUE(std::get<v1::Region>(parse_region("all")).all());
  EXPECT_EQ(std::get<v1::Region>(parse_region("0.5,-1")).nearest().y(), -1.0);
  const v1::Region box = std::get<v1::Region>(parse_region("0,1,2,3"));
  EXPECT_EQ(box.box().min().y(), 1.0);
  EXPECT_EQ(box.box().max().x(), 2.0);
  for (const char* bad : {"", "Top", "middle", "1", "1,2,3", "1,2,3,4,5", "all,1"}) {
    EXPECT_TRUE(refused(parse_region(bad))) << bad;
  }
}

TEST(Arguments, Circles) {
  const v1::Circle circle = std::get<v1::Circle>(parse_circle("0.5,0.25,0.1"));
  EXPECT_EQ(circle.center().y(), 0.25);
  EXPECT_EQ(circle.radius_m(), 0.1);
  for (const char* bad : {"", "1,2", "1,2,3,4", "1,2,x", "1,2,3 "}) EXPECT_TRUE(refused(parse_circle(bad))) << bad;
}

TEST(Arguments, Ellipses) {
  const v1::Ellipse plain = std::get<v1::Ellipse>(parse_ellipse("0.5,0.25,0.2,0.1"));
  EXPECT_EQ(plain.semi_axis_x_m(), 0.2);
  EXPECT_EQ(plain.rotation_rad(), 0.0);
  EXPECT_EQ(std::get<v1::Ellipse>(parse_ellipse("0.5,0.25,0.2,0.1,180")).rotation_rad(), std::acos(-1.0));
  for (const char* bad : {"", "1,2,3", "1,2,3,4,5,6", "1,2,3,x"}) EXPECT_TRUE(refused(parse_ellipse(bad))) << bad;
}

TEST(Arguments, RationalCurves) {
  const v1::Path quadratic = std::get<v1::Path>(parse_rational("0,0,1 1,2,0.5 2,0,1"));
  EXPECT_EQ(quadratic.subpaths(0).segments(0).quadratic().control().y(), 2.0);
  EXPECT_EQ(quadratic.subpaths(0).segments(0).quadratic().weights(1), 0.5);
  const v1::Path cubic = std::get<v1::Path>(parse_rational("0,0,1 1,2,3 2,0,4 5,6,7"));
  EXPECT_EQ(cubic.subpaths(0).segments(0).cubic().control_2().x(), 2.0);
  EXPECT_EQ(cubic.subpaths(0).segments(0).cubic().weights(3), 7.0);
  for (const char* bad : {"", "0,0,1 1,1,1", "0,0 1,1 2,2", "0,0,1 1,1,1 2,2,1 3,3,1 4,4,1", "0,0,1 1,1,x 2,2,1"}) {
    EXPECT_TRUE(refused(parse_rational(bad))) << bad;
  }
}

TEST(Arguments, Paths) {
  const v1::Path path = std::get<v1::Path>(parse_path("M.2.2H.8A.3.3 0 01.2.2ZM1 1l1 1"));
  ASSERT_EQ(path.subpaths_size(), 2);
  EXPECT_TRUE(path.subpaths(0).closed());
  EXPECT_EQ(path.subpaths(0).segments(0).line().x(), 0.8);
  EXPECT_TRUE(path.subpaths(0).segments(1).arc().counter_clockwise());
  EXPECT_EQ(path.subpaths(1).segments(0).line().y(), 2.0);
  for (const char* bad : {"", "M1 1", "L1 1", "M0 0L1", "M0 0L1 1x"}) EXPECT_TRUE(refused(parse_path(bad))) << bad;
}

TEST(Arguments, BoxesAndDashes) {
  const v1::MaterialBox box = std::get<v1::MaterialBox>(parse_fit("0.1,0.2,0.8,0.9"));
  EXPECT_EQ(box.min().y(), 0.2);
  EXPECT_EQ(box.max().x(), 0.8);
  EXPECT_FALSE(std::get<v1::MaterialBox>(parse_fit("sheet")).has_min());
  for (const char* bad : {"", "1,2,3", "1,2,3,4,5", "whole"}) EXPECT_TRUE(refused(parse_fit(bad))) << bad;
  EXPECT_EQ(std::get<std::vector<double>>(parse_dash("0.01,0.005,2")), (std::vector<double>{0.01, 0.005, 2.0}));
  EXPECT_EQ(std::get<std::vector<double>>(parse_dash("0.01")).size(), 1U);
  for (const char* bad : {"", "1,", "1 2", "a"}) EXPECT_TRUE(refused(parse_dash(bad))) << bad;
}

TEST(Arguments, CamerasAndLayers) {
  const v1::Camera camera = std::get<v1::Camera>(parse_camera("0.5,-2,0.5  0.5,0,0.25 0,0,1"));
  EXPECT_EQ(camera.eye().y(), -2.0);
  EXPECT_EQ(camera.target().z(), 0.25);
  EXPECT_EQ(camera.up().z(), 1.0);
  EXPECT_FALSE(std::get<v1::Camera>(parse_camera("0,-2,0 0,0,0")).has_up());
  for (const char* bad : {"", "1,2,3", "1,2 3,4", "1,2,3 4,5,6 7,8,9 1,1,1", "1,2,3 a,b,c"}) {
    EXPECT_TRUE(refused(parse_camera(bad))) << bad;
  }
  EXPECT_EQ(std::get<v1::View>(parse_layers("all")).layers(), v1::View::ALL);
  EXPECT_FALSE(std::get<v1::View>(parse_layers("piece")).has_piece());
  EXPECT_EQ(std::get<v1::View>(parse_layers("piece:3")).piece(), 3);
  const v1::View depth = std::get<v1::View>(parse_layers("depth:1.5,2"));
  EXPECT_EQ(depth.layers(), v1::View::DEPTH_RANGE);
  EXPECT_EQ(depth.nearest_m(), 1.5);
  EXPECT_EQ(depth.farthest_m(), 2.0);
  for (const char* bad : {"", "every", "piece:", "piece:x", "depth", "depth:1", "nearest:1", "all:"}) {
    EXPECT_TRUE(refused(parse_layers(bad))) << bad;
  }
}

TEST(Arguments, ServersHaveAPort) {
  EXPECT_EQ(with_port("127.0.0.1"), "127.0.0.1:50051");
  EXPECT_EQ(with_port("kerf.example.org"), "kerf.example.org:50051");
  EXPECT_EQ(with_port("::1"), "[::1]:50051");
  EXPECT_EQ(with_port("[::1]"), "[::1]:50051");
  for (const char* whole : {"127.0.0.1:8", "[::1]:8", "unix:/run/kerf", "dns:///kerf:8", "localhost:port"}) {
    EXPECT_EQ(with_port(whole), whole);
  }
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
