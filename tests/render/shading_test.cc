#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "render/colours.h"
#include "tests/render/colour_distance.h"
#include "tests/render/fixture.h"

// Tests the visibility of cuts, objects near the ground, pieces, strains, triangles.
namespace kerf::render {
namespace {

using namespace testing;  // NOLINT(google-build-using-namespace)

using RenderShading = RendererTest;

Rgb8 colour_at(const Pixels& pixels, const Camera& camera, Vec3 point) {
  const Rgb colour = pixel_at(pixels, camera, point);
  return {static_cast<std::uint8_t>(colour.red), static_cast<std::uint8_t>(colour.green),
          static_cast<std::uint8_t>(colour.blue)};
}
double lightness(Rgb8 colour) {
  return lab(light_of(colour))[0];
}

// CIELAB lightness of the pixels from `left` to `right` of a row.
std::vector<double> lightness_along(const Pixels& pixels, int left, int right, int row) {
  std::vector<double> along;
  for (int x = left; x <= right; ++x) {
    const Rgb colour = pixel(pixels, x, row);
    along.push_back(lightness({static_cast<std::uint8_t>(colour.red), static_cast<std::uint8_t>(colour.green),
                               static_cast<std::uint8_t>(colour.blue)}));
  }
  return along;
}

TEST_F(RenderShading, LipsOfAClosedCutAreLightOnBothSidesOfADarkLine) {
  const Camera camera = front_camera();
  const Sheet whole = make_sheet(16, 0.0);
  const Sheet cut = make_sheet(16, 0.0, Slit::kClosed);
  for (const int height : {360, 720}) {
    const int width = 16 * height / 9;
    Scene scene = scene_of(cut);
    for (const bool texture : {true, false}) {
      scene.style.texture = texture;
      const Pixels pixels = draw(scene, camera, width, height);
      Scene uncut = scene_of(whole);
      uncut.style.texture = texture;
      const Pixels before = draw(uncut, camera, width, height);
      for (const double z : {-0.19, 0.02, 0.13}) {
        const Place place = project(camera, width, height, {0.0, 0.0, z});
        const int reach = height / 120;  // pixels
        const std::vector<double> across = lightness_along(pixels, place.x - reach, place.x + reach - 1, place.y);
        const std::vector<double> cloth = lightness_along(before, place.x - reach, place.x + reach - 1, place.y);
        const auto middle = across.begin() + reach;
        const double line = std::min(*(middle - 1), *middle);
        const double left = *std::max_element(across.begin(), middle);
        const double right = *std::max_element(middle, across.end());
        EXPECT_GT(std::min(left, right) - line, 35.0) << "of 100; " << height << " " << texture << " " << z;
        if (!texture) {
          EXPECT_GT(std::min(left, right), *std::ranges::max_element(cloth) + 12.0) << height << " " << z;
        }
      }
    }
  }
}

TEST_F(RenderShading, LipsTakeTheColourOfTheStyle) {
  const Camera camera = front_camera();
  const Sheet cut = make_sheet(16, 0.0, Slit::kOpen);
  Scene scene = scene_of(cut);
  scene.style.texture = false;
  scene.style.looks[0].lips = {1.0, 0.1, 0.1};
  const Pixels pixels = draw(scene, camera, 1280, 720);
  // The open slit is 0.1 m wide in its middle, at most; a lip is three pixels wide, of which the line takes one.
  const Place edge = project(camera, 1280, 720, {-0.05, 0.0, 0.0});
  int num_red = 0;
  for (int x = edge.x - 5; x <= edge.x + 2; ++x) {
    const Rgb colour = pixel(pixels, x, edge.y);
    if (colour.red > colour.blue + 60) ++num_red;
  }
  EXPECT_GE(num_red, 1);
  EXPECT_LE(num_red, 4);
  scene.style.borders = false;
  const Pixels unmarked = draw(scene, camera, 1280, 720);
  for (int x = edge.x - 5; x <= edge.x - 2; ++x) EXPECT_TRUE(is_front(pixel(unmarked, x, edge.y))) << x;
}

// The sky's light: the key light's shadow of the ball falls elsewhere.
TEST_F(RenderShading, GroundUnderAHoveringBallIsDark) {
  Scene scene;
  scene.colliders = {Sphere{{0.0, 0.0, 0.36}, 0.3}};
  scene.ground = Plane{{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}};
  Camera camera;
  camera.eye = {0.0, -2.5, 0.9};
  camera.target = {0.0, 0.0, 0.2};
  const Vec3 under{-0.15, -0.15, 0.0};
  const auto darkening = [&](const Scene& drawn) {
    const Pixels pixels = draw(drawn, camera, 640, 360);
    return lightness(colour_at(pixels, camera, {-0.5, -0.1, 0.0})) - lightness(colour_at(pixels, camera, under));
  };
  EXPECT_GT(darkening(scene), 3.5) << "of 100";
  Scene higher = scene;
  higher.colliders = {Sphere{{0.0, 0.0, 1.2}, 0.3}};
  EXPECT_LT(darkening(higher), 0.5 * darkening(scene));
  scene.style.shadows = false;
  EXPECT_NEAR(darkening(scene), 0.0, 1.0);
}

TEST_F(RenderShading, ColoursOfVerticesAreSeenFromBothSides) {
  Sheet sheet = make_sheet(16, 0.0);
  for (std::size_t v = 0; v < sheet.positions.size() / 3; ++v) {
    const std::array<std::uint8_t, 3> colour = vertex(sheet, static_cast<std::int32_t>(v)).z > 0.0
                                                   ? std::array<std::uint8_t, 3>{200, 30, 30}
                                                   : std::array<std::uint8_t, 3>{30, 160, 30};
    sheet.colours.insert(sheet.colours.end(), colour.begin(), colour.end());
  }
  Camera behind = front_camera();
  behind.eye = {0.0, 2.0, 0.0};
  for (const Camera& camera : {front_camera(), behind}) {
    const Pixels pixels = draw(scene_of(sheet), camera);
    for (const double x : {-0.3, 0.0, 0.3}) {
      const Rgb upper = pixel_at(pixels, camera, {x, 0.0, 0.3});
      EXPECT_GT(upper.red, upper.green + 80);
      EXPECT_GT(upper.red, upper.blue + 80);
      const Rgb lower = pixel_at(pixels, camera, {x, 0.0, -0.3});
      EXPECT_GT(lower.green, lower.red + 60);
      EXPECT_GT(lower.green, lower.blue + 60);
    }
  }
}

TEST_F(RenderShading, StrainsHaveTheColoursOfTheirScaleInThePicture) {
  Sheet sheet = make_sheet(20, 0.0);
  std::vector<float> strains;
  for (std::size_t v = 0; v < sheet.positions.size() / 3; ++v) {
    strains.push_back(static_cast<float>(0.04 * vertex(sheet, static_cast<std::int32_t>(v)).x));
  }
  sheet.colours = strain_colours(strains, 0.02);
  Scene scene = scene_of(sheet);
  // Between the light and the sheet: its shadow falls on none of the colours.
  scene.colliders = {Sphere{{-0.26, -0.23, 0.59}, 0.15}};
  const Camera camera = front_camera();
  const Pixels pixels = draw(scene, camera, 640, 480);
  for (int step = -9; step <= 9; ++step) {
    const Rgb8 here = colour_at(pixels, camera, {0.05 * step, 0.0, 0.1});
    EXPECT_LT(distance_of(here, strain_colour(0.1 * step)), 6.0) << step;
  }
}

TEST_F(RenderShading, SheetThatLiesOnTheFloorHidesIt) {
  Sheet sheet = make_sheet(16, 0.0);
  for (std::size_t v = 0; v < sheet.positions.size() / 3; ++v) {
    sheet.colours.insert(sheet.colours.end(), {200, 30, 30});
  }
  Scene scene = scene_of(sheet);
  // Half the thickness of a sheet of paper behind it.
  scene.ground = Plane{{0.0, 5e-5, 0.0}, {0.0, -1.0, 0.0}};
  Camera camera = front_camera();
  camera.eye = {1.5, -1.0, 0.8};
  const Pixels pixels = draw(scene, camera, 640, 480);
  int num_hidden = 0;
  for (int i = -9; i <= 9; ++i) {
    for (int k = -9; k <= 9; ++k) {
      const Rgb colour = pixel_at(pixels, camera, {0.05 * i, 0.0, 0.05 * k});
      if (colour.red < colour.green + 60) ++num_hidden;
    }
  }
  EXPECT_EQ(num_hidden, 0) << "of 361";
}

TEST_F(RenderShading, PiecesByColourAreToldApart) {
  // Seven columns, a piece each, in the palette's order.
  Sheet sheet = make_sheet(28, 0.1);
  for (std::size_t v = 0; v < sheet.positions.size() / 3; ++v) {
    const double u = vertex(sheet, static_cast<std::int32_t>(v)).x + 0.5;
    const Rgb8 colour = piece_colour(1 + std::min<std::int64_t>(6, static_cast<std::int64_t>(7.0 * u + 1e-4)));
    sheet.colours.insert(sheet.colours.end(), colour.begin(), colour.end());
  }
  const Camera camera = front_camera();
  const Pixels pixels = draw(scene_of(sheet), camera, 640, 480);
  std::vector<Rgb8> seen;
  for (int column = 0; column < 7; ++column) {
    seen.push_back(colour_at(pixels, camera, {(column + 0.5) / 7.0 - 0.5, -0.1, 0.05}));
  }
  for (std::size_t a = 0; a < seen.size(); ++a) {
    for (std::size_t b = a + 1; b < seen.size(); ++b) EXPECT_GT(distance_of(seen[a], seen[b]), 20.0) << a << " " << b;
  }
}

// A fine mesh under the wire is neither black nor bare: of triangles 3 pixels high the surface is still seen.
TEST_F(RenderShading, WiresOfAFineMeshLeaveTheSurface) {
  const Camera camera = front_camera();
  const auto mean_lightness = [&](int n, bool wireframe) {
    const Sheet sheet = make_sheet(n, 0.0);
    Scene scene = scene_of(sheet);
    scene.style.wireframe = wireframe;
    scene.style.texture = false;
    const Pixels pixels = draw(scene, camera, 640, 480);
    double sum = 0.0;
    for (int y = 200; y < 280; ++y) {
      for (const double value : lightness_along(pixels, 280, 359, y)) sum += value;
    }
    return sum / (80.0 * 80.0);
  };
  const double bare = mean_lightness(112, false);
  const double coarse = bare - mean_lightness(12, true);
  const double fine = bare - mean_lightness(112, true);
  EXPECT_GT(coarse, 1.0);
  EXPECT_GT(fine, 1.5) << "the wire is seen";
  EXPECT_LT(fine, 16.0) << "and so is the surface";
}

}  // namespace
}  // namespace kerf::render
