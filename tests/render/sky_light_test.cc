#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/shapes.h"
#include "render/sky_light.h"

namespace kerf::render {
namespace {

constexpr PlaneFrame kFrame{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};

// A level square about the z axis, of n x n cells.
std::vector<SurfaceVertex> level_square(double side, double height, int n) {
  std::vector<SurfaceVertex> triangles;
  const auto add = [&](int i, int j) {
    SurfaceVertex vertex{};
    vertex.position = {static_cast<float>(side * (static_cast<double>(i) / n - 0.5)),
                       static_cast<float>(side * (static_cast<double>(j) / n - 0.5)), static_cast<float>(height)};
    triangles.push_back(vertex);
  };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      for (const auto& [di, dj] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}}) add(i + di, j + dj);
    }
  }
  return triangles;
}

float occlusion_at(const SkyLight& sky, float x, float y) {
  std::array<float, SkyLight::kRow> places{};
  places.fill(x);
  return sky.occlusion(places, y).front();
}

// Form factor of a level square above the point under its middle: J. R. Howell's catalogue, B-3, four times.
double form_factor(double side, double height) {
  const double a = 0.5 * side / height;
  const double root = std::sqrt(1.0 + a * a);
  return 4.0 / std::numbers::pi * (a / root) * std::atan(a / root);
}

TEST(SkyLight, IsTakenByASheetAsItsFormFactorSays) {
  for (const double height : {0.2, 0.4, 0.8}) {
    SkyLight sky(kFrame, 1.0);
    sky.add(level_square(1.0, height, 40), 1.0);
    const double expected = 1.0 - std::exp(-form_factor(1.0, height));
    EXPECT_NEAR(occlusion_at(sky, 0.0F, 0.0F), expected, 0.08 * expected) << height;
  }
}

TEST(SkyLight, IsTakenByABallAsItsFormFactorSays) {
  const double radius = 0.25;
  const double height = 0.6;  // of its centre
  SkyLight sky(kFrame, 1.0);
  std::vector<SurfaceVertex> ball;
  append_sphere({{0.0, 0.0, height}, radius}, ball);
  sky.add(ball, 0.5);
  for (const double aside : {0.0, 0.3, 0.8}) {
    const double square = height * height + aside * aside;
    const double expected = 1.0 - std::exp(-height * radius * radius / (square * std::sqrt(square)));
    EXPECT_NEAR(occlusion_at(sky, static_cast<float>(aside), 0.0F), expected, 0.15 * expected) << aside;
  }
}

TEST(SkyLight, IsTakenMostByWhatIsNear) {
  float before = 1.0F;
  for (const double height : {0.001, 0.12, 0.25, 0.6, 1.5}) {  // the first is as good as on the plane
    SkyLight sky(kFrame, 1.0);
    sky.add(level_square(0.5, height, 20), 1.0);
    const float under = occlusion_at(sky, 0.0F, 0.0F);
    EXPECT_LT(under, before) << height;
    EXPECT_LT(occlusion_at(sky, 0.6F, 0.0F), under) << height;
    before = under;
  }
  EXPECT_LT(before, 0.1F);
}

TEST(SkyLight, IsNotTakenByNothingOrByWhatIsBelow) {
  SkyLight sky(kFrame, 1.0);
  EXPECT_EQ(occlusion_at(sky, 0.0F, 0.0F), 0.0F);
  sky.add(level_square(1.0, -0.1, 10), 1.0);
  EXPECT_EQ(occlusion_at(sky, 0.0F, 0.0F), 0.0F);
}

}  // namespace
}  // namespace kerf::render
