#include <gtest/gtest.h>

#include "tests/render/fixture.h"

// Tests the content of pictures.
namespace kerf::render {
namespace {

using namespace testing;  // NOLINT(google-build-using-namespace)

using RenderPicture = RendererTest;

TEST_F(RenderPicture, CoversExactlyWhereTheSheetIs) {
  const Sheet sheet = make_sheet(16, 0.2);
  const Camera camera = front_camera();
  const Pixels pixels = draw(scene_of(sheet), camera);
  for (std::size_t t = 0; t < sheet.triangles.size() / 3; ++t) {
    EXPECT_TRUE(is_front(pixel_at(pixels, camera, centroid(sheet, t)))) << "triangle " << t;
  }
  for (const double s : {-0.45, -0.2, 0.0, 0.2, 0.45}) {
    for (const Vec3 outside : {Vec3{0.56, 0.0, s}, Vec3{-0.56, 0.0, s}, Vec3{s, 0.0, 0.58}, Vec3{s, 0.0, -0.58}}) {
      // The bulge is nearer, so the sheet's upper and lower borders reach beyond where a flat sheet's would.
      const double nearer = std::abs(outside.z) > 0.5 ? 0.2 * (1.0 - 4.0 * s * s) : 0.0;
      EXPECT_EQ(pixel_at(pixels, camera, {outside.x, -nearer, outside.z}), kBackground)
          << outside.x << " " << outside.z;
    }
  }
  for (std::size_t i = 3; i < pixels.rgba.size(); i += 4) ASSERT_EQ(pixels.rgba[i], 255);
}

TEST_F(RenderPicture, IsTheRightWayUpAndRound) {
  // Only the upper right quarter of the sheet, seen from the front.
  Sheet sheet = make_sheet(8, 0.0);
  std::vector<std::int32_t> kept;
  for (std::size_t t = 0; t < sheet.triangles.size() / 3; ++t) {
    const Vec3 c = centroid(sheet, t);
    if (c.x > 0.0 && c.z > 0.0) kept.insert(kept.end(), &sheet.triangles[3 * t], &sheet.triangles[3 * t] + 3);
  }
  sheet.triangles = kept;
  const Pixels pixels = draw(scene_of(sheet));
  EXPECT_TRUE(is_front(pixel(pixels, 160 + 40, 120 - 40)));
  EXPECT_EQ(pixel(pixels, 160 - 40, 120 - 40), kBackground);
  EXPECT_EQ(pixel(pixels, 160 + 40, 120 + 40), kBackground);
}

TEST_F(RenderPicture, ShowsTheOtherColourFromBehind) {
  const Sheet sheet = make_sheet(8, 0.1);
  Camera behind = front_camera();
  behind.eye = {0.0, 2.0, 0.0};
  const Pixels pixels = draw(scene_of(sheet), behind);
  for (std::size_t t = 0; t < sheet.triangles.size() / 3; ++t) {
    EXPECT_TRUE(is_back(pixel_at(pixels, behind, centroid(sheet, t)))) << "triangle " << t;
  }
}

TEST_F(RenderPicture, EachPartHasItsLook) {
  const Sheet sheet = make_sheet(8, 0.1);
  Scene scene = scene_of(sheet);
  std::vector<std::int32_t> looks;
  for (std::size_t t = 0; t < sheet.triangles.size() / 3; ++t) looks.push_back(centroid(sheet, t).x > 0.0 ? 1 : 0);
  scene.mesh.looks = looks;
  scene.style.looks.push_back(scene.style.looks[0]);
  Look& other = scene.style.looks[1];
  std::swap(other.front, other.back);
  std::swap(other.finish.front_dye, other.finish.back_dye);
  const Camera camera = front_camera();
  const Pixels pixels = draw(scene, camera);
  for (std::size_t t = 0; t < sheet.triangles.size() / 3; ++t) {
    const Rgb colour = pixel_at(pixels, camera, centroid(sheet, t));
    EXPECT_TRUE(looks[t] == 1 ? is_back(colour) : is_front(colour)) << "triangle " << t;
  }
}

TEST_F(RenderPicture, BothSidesAreLitAlike) {
  const Sheet sheet = make_sheet(8, 0.0);
  Scene scene = scene_of(sheet);
  scene.style.texture = false;
  scene.style.looks[0].back = scene.style.looks[0].front;
  Camera behind = front_camera();
  behind.eye = {0.0, 2.0, 0.0};
  EXPECT_NEAR(brightness(pixel(draw(scene), 160, 120)), brightness(pixel(draw(scene, behind), 160, 120)), 3);
}

TEST_F(RenderPicture, ShadesByTheDirectionOfTheSurface) {
  // A strong bulge, untextured: the left half faces the light over the left shoulder, the right half turns away.
  const Sheet sheet = make_sheet(16, 0.4);
  Scene scene = scene_of(sheet);
  scene.style.texture = false;
  const Pixels pixels = draw(scene);
  EXPECT_GT(brightness(pixel(pixels, 160 - 50, 120)), brightness(pixel(pixels, 160 + 50, 120)) + 30);
}

TEST_F(RenderPicture, TextureFollowsMaterialCoordinates) {
  const Sheet sheet = make_sheet(20, 0.0);  // a cell a check
  const Camera camera = front_camera();
  const Pixels pixels = draw(scene_of(sheet), camera, 1000, 1000);
  Scene plain = scene_of(sheet);
  plain.style.texture = false;
  const Pixels plain_pixels = draw(plain, camera, 1000, 1000);
  const auto at_check = [&](const Pixels& picture, int i, int j) {
    return brightness(pixel_at(picture, camera, {(i + 0.5) / 20.0 - 0.5, 0.0, (j + 0.5) / 20.0 - 0.5}));
  };
  for (int j = 5; j < 15; ++j) {
    for (int i = 5; i < 15; ++i) {
      // Bands cross: even columns are light, and so are even rows; where both are it is lightest.
      const int across = at_check(pixels, i + 1, j) - at_check(pixels, i, j);
      EXPECT_EQ(across < 0, i % 2 == 0) << i << " " << j;
      EXPECT_GT(std::abs(across), 30);
      const int along = at_check(pixels, i, j + 1) - at_check(pixels, i, j);
      EXPECT_EQ(along < 0, j % 2 == 0) << i << " " << j;
      EXPECT_GT(std::abs(along), 30);
      EXPECT_LT(std::abs(at_check(plain_pixels, i + 1, j) - at_check(plain_pixels, i, j)), 12);
    }
  }
}

TEST_F(RenderPicture, PiecesDifferInColour) {
  Sheet sheet = make_sheet(8, 0.0);
  Scene scene = scene_of(sheet);
  scene.style.texture = false;
  const Pixels one_piece = draw(scene);
  for (std::size_t t = 0; t < sheet.triangles.size() / 3; ++t)
    sheet.pieces.push_back(centroid(sheet, t).x > 0.0 ? 1 : 0);
  scene.mesh = sheet.mesh();
  const Pixels two_pieces = draw(scene);
  EXPECT_EQ(pixel(one_piece, 120, 100), pixel(two_pieces, 120, 100));
  const Rgb before = pixel(one_piece, 200, 100);
  const Rgb after = pixel(two_pieces, 200, 100);
  EXPECT_GT(
      std::abs(before.red - after.red) + std::abs(before.green - after.green) + std::abs(before.blue - after.blue), 20);
  EXPECT_TRUE(is_front(after));
}

TEST_F(RenderPicture, WireframeDarkensEdgesAndNothingElse) {
  const Sheet sheet = make_sheet(4, 0.0);
  const Camera camera = front_camera();
  Scene scene = scene_of(sheet);
  scene.style.texture = false;
  const Pixels without = draw(scene, camera, 640, 480);
  scene.style.wireframe = true;
  const Pixels with = draw(scene, camera, 640, 480);
  for (std::size_t t = 0; t < sheet.triangles.size() / 3; ++t) {
    const Vec3 middle = centroid(sheet, t);
    EXPECT_EQ(pixel_at(without, camera, middle), pixel_at(with, camera, middle)) << "triangle " << t;
    const Vec3 on_diagonal =
        0.5 * (vertex(sheet, sheet.triangles[3 * t]) + vertex(sheet, sheet.triangles[3 * t + (t % 2 == 0 ? 2 : 1)]));
    EXPECT_LT(brightness(pixel_at(with, camera, on_diagonal)), brightness(pixel_at(without, camera, on_diagonal)) - 60)
        << "triangle " << t;
  }
}

TEST_F(RenderPicture, AnOpenCutShowsWhatIsBehind) {
  const Camera camera = front_camera();
  const Vec3 middle{0.0, 0.0, 0.0};
  const Sheet whole = make_sheet(16, 0.0);
  const Sheet cut = make_sheet(16, 0.0, Slit::kOpen);
  EXPECT_TRUE(is_front(pixel_at(draw(scene_of(whole)), camera, middle)));
  EXPECT_EQ(pixel_at(draw(scene_of(cut)), camera, middle), kBackground);
}

TEST_F(RenderPicture, AClosedCutShowsAsADarkLine) {
  const Camera camera = front_camera();
  const Sheet whole = make_sheet(16, 0.0);
  const Sheet cut = make_sheet(16, 0.0, Slit::kClosed);
  const Pixels before = draw(scene_of(whole), camera, 640, 480);
  const Pixels after = draw(scene_of(cut), camera, 640, 480);
  for (const double z : {-0.2, -0.1, 0.0, 0.1, 0.2}) {
    EXPECT_LT(brightness(pixel_at(after, camera, {0.0, 0.0, z})),
              brightness(pixel_at(before, camera, {0.0, 0.0, z})) / 2);
    EXPECT_EQ(pixel_at(after, camera, {0.1, 0.0, z}), pixel_at(before, camera, {0.1, 0.0, z}));
  }
  Scene unmarked = scene_of(cut);
  unmarked.style.borders = false;
  EXPECT_EQ(pixel_at(draw(unmarked, camera, 640, 480), camera, {0.0, 0.0, 0.1}),
            pixel_at(before, camera, {0.0, 0.0, 0.1}));
}

TEST_F(RenderPicture, NearerThingsHideFartherOnes) {
  const Sheet sheet = make_sheet(8, 0.0);
  Scene scene = scene_of(sheet);
  scene.colliders = {Sphere{{-0.25, -0.3, 0.25}, 0.1}, Sphere{{0.25, 0.3, 0.25}, 0.1},
                     Box{{-0.25, -0.3, -0.25}, {0.1, 0.05, 0.1}},
                     Capsule{{0.2, -0.3, -0.25}, {0.3, -0.3, -0.25}, 0.08}};
  const Camera camera = front_camera();
  const Pixels pixels = draw(scene, camera);
  const auto is_grey = [](Rgb colour) { return std::abs(colour.red - colour.blue) < 40 && brightness(colour) < 720; };
  EXPECT_TRUE(is_grey(pixel_at(pixels, camera, {-0.25, -0.4, 0.25}))) << "the sphere before the sheet";
  EXPECT_TRUE(is_front(pixel_at(pixels, camera, {0.25, 0.0, 0.25}))) << "the sphere behind the sheet";
  EXPECT_TRUE(is_grey(pixel_at(pixels, camera, {-0.25, -0.35, -0.25}))) << "the box";
  EXPECT_TRUE(is_grey(pixel_at(pixels, camera, {0.25, -0.38, -0.25}))) << "the capsule";
}

TEST_F(RenderPicture, ARotatedBoxIsWhereItsCornersAre) {
  Scene scene;
  const double half_turn = std::sqrt(0.5);  // 45 degrees about y: cos and sin of 22.5 degrees below
  scene.colliders = {Box{{0.0, 0.0, 0.0}, {0.3, 0.1, 0.3}, {0.92387953, 0.0, 0.38268343, 0.0}}};
  const Camera camera = front_camera();
  const Pixels pixels = draw(scene, camera);
  const double reach = 0.3 / half_turn;  // of a corner, along x and z
  EXPECT_NE(pixel_at(pixels, camera, {0.93 * reach, -0.1, 0.0}), kBackground);
  EXPECT_NE(pixel_at(pixels, camera, {0.0, -0.1, 0.93 * reach}), kBackground);
  EXPECT_EQ(pixel_at(pixels, camera, {0.28, -0.1, 0.28}), kBackground) << "a corner of the box before it was turned";
}

TEST_F(RenderPicture, ASheetLyingOnASphereHidesIt) {
  // Vertices on the sphere; the middles of the triangles are below its surface.
  Sheet sheet = make_sheet(16, 0.0);
  for (std::int32_t v = 0; v < static_cast<std::int32_t>(sheet.positions.size() / 3); ++v) {
    const Vec3 from_above{vertex(sheet, v).x * 0.5, -0.5, vertex(sheet, v).z * 0.5};
    const Vec3 on_sphere = 0.5 * normalized(from_above);
    const std::size_t at = 3 * static_cast<std::size_t>(v);
    sheet.positions[at] = static_cast<float>(on_sphere.x);
    sheet.positions[at + 1] = static_cast<float>(on_sphere.y);
    sheet.positions[at + 2] = static_cast<float>(on_sphere.z);
  }
  Scene scene = scene_of(sheet);
  scene.colliders = {Sphere{{0.0, 0.0, 0.0}, 0.5}};
  scene.style.borders = false;
  const Camera camera = front_camera();
  const Pixels pixels = draw(scene, camera);
  for (std::size_t t = 0; t < sheet.triangles.size() / 3; ++t) {
    EXPECT_TRUE(is_front(pixel_at(pixels, camera, centroid(sheet, t)))) << "triangle " << t;
  }
}

TEST_F(RenderPicture, ThingsCastShadowsOnTheGround) {
  Scene scene;
  scene.colliders = {Sphere{{0.0, 0.0, 0.0}, 0.3}};
  scene.ground = Plane{{0.0, 0.0, -0.3}, {0.0, 0.0, 2.0}};
  Camera camera;
  camera.eye = {0.0, -2.5, 1.5};
  const Vec3 in_shadow{0.3, 0.15, -0.3};  // beside the sphere, away from the light
  const Vec3 in_light{-0.6, 0.0, -0.3};
  const Pixels with = draw(scene, camera);
  EXPECT_LT(brightness(pixel_at(with, camera, in_shadow)), brightness(pixel_at(with, camera, in_light)) - 60);
  scene.style.shadows = false;
  const Pixels without = draw(scene, camera);
  EXPECT_NEAR(brightness(pixel_at(without, camera, in_shadow)), brightness(pixel_at(without, camera, in_light)), 12);
  Camera below = camera;
  below.eye = {0.0, -2.5, -1.5};
  EXPECT_EQ(pixel_at(draw(scene, below), below, in_light), kBackground) << "ground is seen from above only";
}

TEST_F(RenderPicture, ALitSurfaceDoesNotShadeItself) {
  // Convex, so no part of it stands in another's light.
  const Sheet sheet = make_sheet(32, 0.3);
  const Camera camera = front_camera();
  Scene scene = scene_of(sheet);
  const Pixels with = draw(scene, camera, 640, 480);
  scene.style.shadows = false;
  const Pixels without = draw(scene, camera, 640, 480);
  for (std::size_t t = 0; t < sheet.triangles.size() / 3; ++t) {
    const int lit = brightness(pixel_at(without, camera, centroid(sheet, t)));
    EXPECT_NEAR(brightness(pixel_at(with, camera, centroid(sheet, t))), lit, 10) << "triangle " << t;
  }
}

TEST_F(RenderPicture, AnEmptySceneIsAllBackground) {
  Scene scene;
  scene.style.background = {0.2, 0.4, 0.6};
  const Pixels pixels = draw(scene);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) ASSERT_EQ(pixel(pixels, x, y), (Rgb{51, 102, 153})) << x << " " << y;
  }
}

TEST_F(RenderPicture, TheBackgroundChangesDownThePicture) {
  Scene scene;
  scene.style.background = {1.0, 0.0, 0.2};
  scene.style.background_below = Colour{0.0, 1.0, 0.2};
  const Pixels pixels = draw(scene);
  for (int y = 0; y < 240; ++y) {
    const Rgb colour = pixel(pixels, y, y);
    const double down = (y + 0.5) / 240.0;
    EXPECT_NEAR(colour.red, 255.0 * (1.0 - down), 1.0) << y;
    EXPECT_NEAR(colour.green, 255.0 * down, 1.0) << y;
    EXPECT_EQ(colour.blue, 51) << y;
  }
}

TEST_F(RenderPicture, PatternsDiffer) {
  const Sheet sheet = make_sheet(8, 0.0);
  Scene scene = scene_of(sheet);
  scene.style.looks[0].finish.contrast = 0.5;
  Camera camera = front_camera();
  camera.eye.y = -0.6;
  std::vector<Pixels> pictures;
  for (const Pattern pattern : {Pattern::kGingham, Pattern::kWeave, Pattern::kTwill, Pattern::kGrain, Pattern::kKnit}) {
    scene.style.looks[0].finish.pattern = pattern;
    pictures.push_back(draw(scene, camera, 480, 480));
  }
  for (std::size_t a = 0; a < pictures.size(); ++a) {
    for (std::size_t b = a + 1; b < pictures.size(); ++b) {
      int num_different = 0;
      for (int y = 140; y < 340; ++y) {
        for (int x = 140; x < 340; ++x) {
          if (std::abs(brightness(pixel(pictures[a], x, y)) - brightness(pixel(pictures[b], x, y))) > 15) {
            ++num_different;
          }
        }
      }
      EXPECT_GT(num_different, 8000) << "of 40000; patterns " << a << " and " << b;
    }
  }
}

TEST_F(RenderPicture, AKeyLightWithAPlaceStaysThere) {
  const Sheet sheet = make_sheet(16, 0.4);
  Scene scene = scene_of(sheet);
  scene.style.texture = false;
  scene.style.light.towards_key = Vec3{2.0, -1.0, 0.5};
  const Pixels pixels = draw(scene);
  EXPECT_GT(brightness(pixel(pixels, 160 + 50, 120)), brightness(pixel(pixels, 160 - 50, 120)) + 30);
  scene.style.light.towards_key = Vec3{};
  EXPECT_EQ(validate(scene).field, "scene.style.light.towards_key");
}

TEST_F(RenderPicture, ShadowsReachGroundFarFromWhatCastsThem) {
  Scene scene;
  scene.colliders = {Sphere{{0.0, 0.0, 0.3}, 0.3}};
  scene.ground = Plane{{0.0, 0.0, -0.6}, {0.0, 0.0, 1.0}};
  scene.style.light.towards_key = Vec3{-1.0, 0.0, 1.0};
  Camera camera;
  camera.eye = {0.0, -2.5, 1.5};
  const Pixels pixels = draw(scene, camera);
  const int lit = brightness(pixel_at(pixels, camera, {-0.7, 0.0, -0.6}));
  EXPECT_LT(brightness(pixel_at(pixels, camera, {0.9, 0.0, -0.6})), lit - 60);
}

TEST_F(RenderPicture, AViewFromInsideTheSceneIsDrawn) {
  const Sheet sheet = make_sheet(16, 0.0);
  Scene scene = scene_of(sheet);
  Camera camera;
  camera.eye = {0.0, 0.001, -0.2};  // beside the sheet, which passes the near plane on both sides
  camera.target = {0.0, 0.0, 0.5};
  camera.up = {0.0, 1.0, 0.0};
  const Pixels pixels = draw(scene, camera);
  EXPECT_TRUE(is_back(pixel(pixels, 160, 230)));
  EXPECT_EQ(pixel(pixels, 160, 10), kBackground);
}

TEST_F(RenderPicture, AFittedCameraSeesAllOfIt) {
  const Sheet sheet = make_sheet(8, 0.3);
  for (const double aspect : {0.5, 1.0, 2.0}) {
    const Camera camera = fit_camera(sheet.mesh().positions, aspect);
    const int height = 200;
    const int width = static_cast<int>(height * aspect);
    const Pixels pixels = draw(scene_of(sheet), camera, width, height);
    int covered = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (pixel(pixels, x, y) == kBackground) continue;
        ++covered;
        ASSERT_TRUE(x > 0 && y > 0 && x + 1 < width && y + 1 < height) << "cut off at " << x << " " << y;
      }
    }
    EXPECT_GT(covered, width * height / (aspect > 1.5 ? 8 : 5));
  }
}

TEST_F(RenderPicture, WithoutAntialiasingEdgesAreHard) {
  const Sheet sheet = make_sheet(4, 0.0);
  Scene scene = scene_of(sheet);
  scene.style.borders = false;
  scene.style.texture = false;
  Camera camera = front_camera();
  camera.up = {0.2, 0.0, 1.0};  // slanted edges
  const auto colours_beyond = [&](const Pixels& pixels) {
    int mixed = 0;  // neither background nor sheet
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 320; ++x) {
        const Rgb colour = pixel(pixels, x, y);
        if (colour != kBackground && colour.blue - colour.red < 60) ++mixed;
      }
    }
    return mixed;
  };
  EXPECT_GT(colours_beyond(draw(scene, camera)), 100);
  scene.style.antialias = false;
  EXPECT_EQ(colours_beyond(draw(scene, camera)), 0);
}

}  // namespace
}  // namespace kerf::render
