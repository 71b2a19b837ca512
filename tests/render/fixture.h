#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "render/renderer.h"
#include "tests/render/scenes.h"

namespace kerf::render::testing {

inline constexpr Rgb kBackground{237, 240, 245};  // Style's default, times 255

inline int brightness(Rgb colour) {
  return colour.red + colour.green + colour.blue;
}
inline bool is_front(Rgb colour) {
  return colour.blue > colour.red + 15;
}
inline bool is_back(Rgb colour) {
  return colour.red > colour.blue + 15;
}

// One renderer for all tests of a suite.
class RendererTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { renderer_ = make_renderer().release(); }
  static void TearDownTestSuite() { delete renderer_; }

  void SetUp() override {
    ASSERT_TRUE(renderer_->available()) << renderer_->description()
                                        << "; install libegl-mesa0 and libgl1-mesa-dri, or configure KERF_RENDER=OFF";
  }

  static Pixels draw(const Scene& scene, const Camera& camera = front_camera(), int width = 320, int height = 240) {
    Pixels pixels;
    const Status status = renderer_->render(scene, camera, width, height, pixels);
    EXPECT_TRUE(status.ok()) << status.reason << ": " << status.message << " " << status.field;
    EXPECT_EQ(pixels.width, width);
    EXPECT_EQ(pixels.height, height);
    EXPECT_EQ(pixels.rgba.size(), static_cast<std::size_t>(4 * width * height));
    return pixels;
  }

  static inline Renderer* renderer_ = nullptr;
};

inline Scene scene_of(const Sheet& sheet) {
  Scene scene;
  scene.mesh = sheet.mesh();
  return scene;
}

}  // namespace kerf::render::testing
