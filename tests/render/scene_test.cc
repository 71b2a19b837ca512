#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "render/borders.h"
#include "render/draw_list.h"
#include "render/sheet_shape.h"
#include "render/views.h"
#include "tests/render/scenes.h"

namespace kerf::render {
namespace {

using testing::make_sheet;
using testing::Sheet;
using testing::Slit;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kNanFloat = std::numeric_limits<float>::quiet_NaN();

// Refused with this reason for this field, with words for people.
void expect_refused(const Status& status, const std::string& reason, const std::string& field) {
  EXPECT_EQ(status.code, StatusCode::kInvalidArgument) << field;
  EXPECT_EQ(status.reason, reason) << field;
  EXPECT_EQ(status.field, field);
  EXPECT_FALSE(status.message.empty()) << field;
}

TEST(RenderCamera, GoodOnesPass) {
  EXPECT_TRUE(validate(Camera{}).ok());
  Camera camera;
  camera.vertical_fov = 1.0;
  EXPECT_TRUE(validate(camera).ok());
  camera.vertical_fov = 179.0;
  EXPECT_TRUE(validate(camera).ok());
  camera.up = {0.0, 0.0, 1e-3};  // any length
  EXPECT_TRUE(validate(camera).ok());
  camera.up = {0.0, 1.0, -1.0 / 3.0 + 0.01};  // nearly along the view
  EXPECT_TRUE(validate(camera).ok());
}

TEST(RenderCamera, SingularOnesAreRefusedByField) {
  Camera same;
  same.target = same.eye;
  expect_refused(validate(same), "CAMERA_SINGULAR", "camera.target");
  Camera along;
  along.up = {0.0, -3.0, 1.0};  // from the default target to the default eye
  expect_refused(validate(along), "CAMERA_SINGULAR", "camera.up");
  along.up = {0.0, 3.0, -1.0};
  expect_refused(validate(along), "CAMERA_SINGULAR", "camera.up");
  Camera no_up;
  no_up.up = {0.0, 0.0, 0.0};
  expect_refused(validate(no_up), "CAMERA_SINGULAR", "camera.up");
  for (const double fov : {0.0, 0.99, 179.01, 180.0, -40.0}) {
    Camera camera;
    camera.vertical_fov = fov;
    expect_refused(validate(camera), "FOV_OUT_OF_RANGE", "camera.vertical_fov");
  }
}

TEST(RenderCamera, NumbersThatAreNoneAreRefusedByField) {
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    Camera camera;
    camera.eye.y = bad;
    expect_refused(validate(camera), "CAMERA_NOT_FINITE", "camera.eye");
    camera = {};
    camera.target.z = bad;
    expect_refused(validate(camera), "CAMERA_NOT_FINITE", "camera.target");
    camera = {};
    camera.up.x = bad;
    expect_refused(validate(camera), "CAMERA_NOT_FINITE", "camera.up");
    camera = {};
    camera.vertical_fov = bad;
    expect_refused(validate(camera), "CAMERA_NOT_FINITE", "camera.vertical_fov");
  }
  Camera camera;
  camera.eye.x = 2.0 * kMaxCoordinate;
  expect_refused(validate(camera), "LIMIT_EXCEEDED", "camera.eye");
}

TEST(RenderScene, BadMeshesAreRefusedByField) {
  const Sheet good = make_sheet(4, 0.1);
  const auto status_of = [](const Sheet& sheet) {
    Scene scene;
    scene.mesh = sheet.mesh();
    return validate(scene);
  };
  EXPECT_TRUE(status_of(good).ok());
  Sheet sheet = good;
  sheet.positions[7] = kNanFloat;
  expect_refused(status_of(sheet), "NOT_FINITE", "scene.mesh.positions");
  sheet = good;
  sheet.positions[7] = 3e38F;
  expect_refused(status_of(sheet), "LIMIT_EXCEEDED", "scene.mesh.positions");
  sheet = good;
  sheet.positions.pop_back();
  expect_refused(status_of(sheet), "ARRAY_SIZE_MISMATCH", "scene.mesh.positions");
  sheet = good;
  sheet.material[3] = kNanFloat;
  expect_refused(status_of(sheet), "NOT_FINITE", "scene.mesh.material_coordinates");
  sheet = good;
  sheet.material.resize(10);
  expect_refused(status_of(sheet), "ARRAY_SIZE_MISMATCH", "scene.mesh.material_coordinates");
  sheet = good;
  sheet.triangles[5] = 25;  // there are 25 vertices
  expect_refused(status_of(sheet), "INDEX_OUT_OF_RANGE", "scene.mesh.triangles");
  sheet.triangles[5] = -1;
  expect_refused(status_of(sheet), "INDEX_OUT_OF_RANGE", "scene.mesh.triangles");
  sheet = good;
  sheet.triangles.push_back(0);
  expect_refused(status_of(sheet), "ARRAY_SIZE_MISMATCH", "scene.mesh.triangles");
  sheet = good;
  sheet.pieces = {0, 1};
  expect_refused(status_of(sheet), "ARRAY_SIZE_MISMATCH", "scene.mesh.piece_ids");
  sheet.pieces.assign(32, -1);
  expect_refused(status_of(sheet), "INDEX_OUT_OF_RANGE", "scene.mesh.piece_ids");
  sheet = good;
  sheet.colours.assign(good.positions.size() - 1, 0);
  expect_refused(status_of(sheet), "ARRAY_SIZE_MISMATCH", "scene.mesh.vertex_colours");
  sheet = good;
  sheet.triangles.assign(3 * (kMaxTriangles + 1), 0);
  expect_refused(status_of(sheet), "LIMIT_EXCEEDED", "scene.mesh.triangles");
}

TEST(RenderScene, BadCollidersAndColoursAreRefusedByField) {
  const auto status_of = [](const Collider& collider) {
    Scene scene;
    scene.colliders = {Sphere{{0.0, 0.0, 0.0}, 1.0}, collider};
    return validate(scene);
  };
  expect_refused(status_of(Sphere{{0.0, kNan, 0.0}, 1.0}), "NOT_FINITE", "scene.colliders[1].centre");
  expect_refused(status_of(Sphere{{0.0, 0.0, 0.0}, 0.0}), "SHAPE_DEGENERATE", "scene.colliders[1].radius");
  expect_refused(status_of(Sphere{{0.0, 0.0, 0.0}, 1e7}), "LIMIT_EXCEEDED", "scene.colliders[1].radius");
  expect_refused(status_of(Plane{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}), "SHAPE_DEGENERATE", "scene.colliders[1].normal");
  expect_refused(status_of(Box{{0.0, 0.0, 0.0}, {1.0, -1.0, 1.0}}), "SHAPE_DEGENERATE",
                 "scene.colliders[1].half_extents");
  expect_refused(status_of(Box{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, {0.0, 0.0, 0.0, 0.0}}), "SHAPE_DEGENERATE",
                 "scene.colliders[1].rotation");
  expect_refused(status_of(Capsule{{0.0, 0.0, 0.0}, {0.0, 0.0, kInfinity}, 1.0}), "NOT_FINITE",
                 "scene.colliders[1].end");
  EXPECT_TRUE(status_of(Capsule{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 1.0}).ok());

  Scene scene;
  scene.colliders.assign(kMaxColliders, Sphere{{0.0, 0.0, 0.0}, 1.0});
  EXPECT_TRUE(validate(scene).ok());
  scene.colliders.push_back(Sphere{{0.0, 0.0, 0.0}, 1.0});
  expect_refused(validate(scene), "LIMIT_EXCEEDED", "scene.colliders");
  scene = {};
  scene.ground = Plane{{0.0, 0.0, 0.0}, {0.0, kNan, 0.0}};
  expect_refused(validate(scene), "NOT_FINITE", "scene.ground.normal");
  scene = {};
  scene.style.looks[0].back.green = 1.01;
  expect_refused(validate(scene), "COLOUR_OUT_OF_RANGE", "scene.style.looks[0].back");
  scene.style = {};
  scene.style.looks[0].lips.red = -0.01;
  expect_refused(validate(scene), "COLOUR_OUT_OF_RANGE", "scene.style.looks[0].lips");
  scene.style.looks = std::vector<Look>(kMaxLooks + 1);
  expect_refused(validate(scene), "LIMIT_EXCEEDED", "scene.style.looks");
  scene.style.looks.clear();
  expect_refused(validate(scene), "LIMIT_EXCEEDED", "scene.style.looks");
  scene.style = {};
  scene.style.looks[0].back.green = kNan;
  expect_refused(validate(scene), "COLOUR_OUT_OF_RANGE", "scene.style.looks[0].back");
}

std::size_t num_borders(const Sheet& sheet) {
  return border_edges(sheet.triangles, sheet.positions.size() / 3).size();
}

TEST(RenderBorders, AreTheEdgesOfOneTriangleOnly) {
  // 8 x 8 cells: 32 edges around. The slit opens the column between rows 2 and 6: four edges, two lips each.
  EXPECT_EQ(num_borders(make_sheet(8, 0.0)), 32U);
  EXPECT_EQ(num_borders(make_sheet(8, 0.0, Slit::kClosed)), 32U + 2U * 4U);
  EXPECT_TRUE(border_edges({}, 0).empty());
  const std::vector<std::int32_t> one{4, 2, 7};
  EXPECT_EQ(border_edges(one, 8), (std::vector<std::array<std::int32_t, 4>>{{4, 2, 7, 0}, {2, 7, 4, 0}, {7, 4, 2, 0}}));
  // Three triangles on one edge: that edge is no border.
  const std::vector<std::int32_t> book{0, 1, 2, 1, 0, 3, 0, 1, 4};
  EXPECT_EQ(border_edges(book, 5).size(), 6U);
}

Vec3 to_vec3(const Float3& v) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

TEST(RenderBorders, LipsReachIntoTheSheetAndMeet) {
  const Sheet sheet = make_sheet(8, 0.0, Slit::kClosed);
  const Mesh mesh = sheet.mesh();
  int num_lips = 0;  // of the slit at x = 0
  for (const BorderSegment& segment : border_segments(mesh, vertex_normals(mesh))) {
    const Vec3 start = to_vec3(segment.start);
    const Vec3 end = to_vec3(segment.end);
    EXPECT_NEAR(to_vec3(segment.start_normal).y, -1.0, 1e-6);
    if (std::abs(start.x) < 1e-6 && std::abs(end.x) < 1e-6) {
      ++num_lips;
      // The triangle is on the left of the edge, seen from -y.
      EXPECT_NEAR(to_vec3(segment.start_inward).x, end.z > start.z ? -1.0 : 1.0, 1e-5);
      EXPECT_NEAR(to_vec3(segment.end_inward).z, 0.0, 1e-5);
      continue;
    }
    for (const auto& [place, inward] : {std::pair{start, segment.start_inward}, {end, segment.end_inward}}) {
      // On the outer border a strip ends at the inset square, also at the corners.
      const Vec3 inner = place + 0.1 * to_vec3(inward);
      EXPECT_NEAR(std::max(std::abs(inner.x), std::abs(inner.z)), 0.4, 1e-5);
    }
  }
  EXPECT_EQ(num_lips, 8);
}

TEST(RenderRidges, AreWhereTheSheetBulges) {
  Sheet sheet = make_sheet(16, 0.3);  // y = -1.2 u (1 - u): curvature 2.4 / m across, none along, seen on the ridge
  const Mesh mesh = sheet.mesh();
  const std::vector<float> heights = ridges(mesh, vertex_normals(mesh), 0.1);
  const std::size_t middle = 8 * 17 + 8;
  // Two of the six edges at a vertex go across, two along, two askew.
  EXPECT_GT(heights[middle], 0.08F);
  EXPECT_LT(heights[middle], 0.24F);
  for (std::size_t i = 0; i < sheet.triangles.size(); i += 3) std::swap(sheet.triangles[i], sheet.triangles[i + 1]);
  const Mesh turned = sheet.mesh();
  EXPECT_FLOAT_EQ(ridges(turned, vertex_normals(turned), 0.1)[middle], -heights[middle]);
  const Sheet flat = make_sheet(4, 0.0);
  for (const float height : ridges(flat.mesh(), vertex_normals(flat.mesh()), 10.0)) EXPECT_EQ(height, 0.0F);
}

TEST(RenderNormals, AreUnitAndPointToTheFront) {
  const Sheet sheet = make_sheet(16, 0.3);
  Scene scene;
  scene.mesh = sheet.mesh();
  const DrawList list = make_draw_list(scene, Camera{}, 64, 64);
  ASSERT_EQ(list.sheet.size(), sheet.triangles.size());
  for (const SurfaceVertex& corner : list.sheet) {
    const Vec3 normal{static_cast<double>(corner.normal[0]), static_cast<double>(corner.normal[1]),
                      static_cast<double>(corner.normal[2])};
    EXPECT_NEAR(norm(normal), 1.0, 1e-5);
    EXPECT_LT(normal.y, -0.5);
    // Compares with the parabola y = -1.2 u (1 - u): within the error of a sixteenth's facets, at half of it on the
    // border.
    const double slope = -1.2 * (1.0 - 2.0 * (static_cast<double>(corner.position[0]) + 0.5));
    EXPECT_NEAR(normal.x / normal.y, -slope, 0.09);
    EXPECT_NEAR(normal.z, 0.0, 1e-5);
  }
}

TEST(RenderViews, ProjectAsAPinholeCameraDoes) {
  const std::array<float, 12> positions{0.0F, 0.0F, 0.0F, 1.0F, 1.0F, 2.0F, -1.0F, -2.0F, -0.5F, 0.3F, -0.4F, 1.1F};
  const Camera camera = fit_camera(positions, 1.5);
  const Bounds bounds{{-1.0, -2.0, -0.5}, {1.0, 1.0, 2.0}};
  const Views views = make_views(camera, 1.5, 600, bounds, bounds);
  for (const Vec3 point : {Vec3{0.0, 0.0, 0.0}, Vec3{1.0, 1.0, 2.0}, Vec3{-1.0, -2.0, -0.5}, Vec3{0.3, -0.4, 1.1}}) {
    std::array<double, 4> clip{};
    for (std::size_t row = 0; row < 4; ++row) {
      clip[row] = views.clip_from_world.at(row, 0) * point.x + views.clip_from_world.at(row, 1) * point.y +
                  views.clip_from_world.at(row, 2) * point.z + views.clip_from_world.at(row, 3);
    }
    const testing::Place place = testing::project(camera, 900, 600, point);
    EXPECT_NEAR(450.0 * (1.0 + clip[0] / clip[3]), place.x + 0.5, 0.51);
    EXPECT_NEAR(300.0 * (1.0 - clip[1] / clip[3]), place.y + 0.5, 0.51);
    EXPECT_LT(std::abs(clip[2] / clip[3]), 1.0) << "between near and far";
    EXPECT_LT(std::abs(clip[0] / clip[3]), 1.0) << "a fitted camera sees all of it";
    EXPECT_LT(std::abs(clip[1] / clip[3]), 1.0);
  }
}

TEST(RenderViews, AFittedCameraLeavesASmallMargin) {
  const Sheet sheet = make_sheet(16, 0.25);
  for (const double aspect : {0.5, 1.0, 2.0}) {
    const Camera camera = fit_camera(sheet.mesh().positions, aspect);
    const Bounds bounds = bounds_of(sheet.mesh());
    const Views views = make_views(camera, aspect, 600, bounds, bounds);
    double reach = 0.0;  // of clip space, whose border is at 1
    for (std::size_t i = 0; i < sheet.mesh().positions.size(); i += 3) {
      const auto at = [&](std::size_t row) {
        double sum = views.clip_from_world.at(row, 3);
        for (std::size_t k = 0; k < 3; ++k) {
          sum += views.clip_from_world.at(row, k) * static_cast<double>(sheet.mesh().positions[i + k]);
        }
        return sum;
      };
      reach = std::max({reach, std::abs(at(0) / at(3)), std::abs(at(1) / at(3))});
    }
    EXPECT_NEAR(reach, 0.94, 0.001) << aspect;
  }
}

TEST(RenderViews, AFittedCameraIsValidForAnyPositions) {
  const std::vector<float> point{5.0F, 5.0F, 5.0F};
  const std::vector<float> line{0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 3.0F};
  const std::vector<float> towards_the_eye{0.0F, 0.0F, 0.0F, 0.55F, -1.0F, 0.55F};
  for (const std::vector<float>& positions : {std::vector<float>{}, point, line, towards_the_eye}) {
    for (const double aspect : {0.01, 1.0, 100.0}) EXPECT_TRUE(validate(fit_camera(positions, aspect)).ok());
  }
}

TEST(RenderViews, BoundsHoldEveryVertex) {
  const Sheet sheet = make_sheet(4, 0.25);
  const Bounds bounds = bounds_of(sheet.mesh());
  EXPECT_DOUBLE_EQ(bounds.lower.x, -0.5);
  EXPECT_DOUBLE_EQ(bounds.upper.x, 0.5);
  EXPECT_DOUBLE_EQ(bounds.lower.y, -0.25);
  EXPECT_DOUBLE_EQ(bounds.upper.y, 0.0);
  EXPECT_TRUE(is_empty(bounds_of(Mesh{})));
}

}  // namespace
}  // namespace kerf::render
