#include <gtest/gtest.h>

#include <thread>

#include "render/gl_canvas.h"
#include "tests/render/fixture.h"

// Tests calls of the renderer.
namespace kerf::render {
namespace {

using namespace testing;  // NOLINT(google-build-using-namespace)

using RenderCalls = RendererTest;

TEST_F(RenderCalls, DescribesTheDevice) {
  EXPECT_NE(renderer_->description().find("OpenGL"), std::string::npos) << renderer_->description();
  EXPECT_NE(renderer_->description().find("EGL"), std::string::npos) << renderer_->description();
}

TEST_F(RenderCalls, TheSameSceneGivesTheSameBytes) {
  const Sheet sheet = make_sheet(16, 0.3, Slit::kOpen);
  Scene scene = scene_of(sheet);
  scene.colliders = {Sphere{{0.0, 0.3, 0.0}, 0.3}};
  scene.ground = Plane{{0.0, 0.0, -0.6}, {0.0, 0.0, 1.0}};
  scene.style.wireframe = true;
  const Pixels first = draw(scene);
  draw(scene, front_camera(), 64, 48);  // Draws something else in between, so that the targets are made again.
  EXPECT_EQ(first.rgba, draw(scene).rgba);
  const std::unique_ptr<Renderer> other = make_renderer();
  Pixels by_other;
  ASSERT_TRUE(other->render(scene, front_camera(), 320, 240, by_other).ok());
  EXPECT_EQ(first.rgba, by_other.rgba);
}

TEST_F(RenderCalls, TheDeviceForcedIsTheOneThatDraws) {
  const std::vector<DeviceOutcome> probed = probe_devices();
  ASSERT_FALSE(probed.empty());
  int num_chosen = 0;
  for (std::size_t i = 0; i < probed.size(); ++i) {
    EXPECT_NE(probed[i].state, DeviceState::kNotTried) << probed[i].device.name;
    if (probed[i].state == DeviceState::kChosen) ++num_chosen;
    const std::string number = std::to_string(i);
    EXPECT_TRUE(check_device(number).ok());
    const std::unique_ptr<Renderer> forced = make_renderer({.device = number});
    EXPECT_EQ(forced->available(), probed[i].state != DeviceState::kRejected) << forced->description();
    if (forced->available()) {
      EXPECT_EQ(forced->description(), probed[i].device.name + ", " + probed[i].words);
    }
    ASSERT_EQ(forced->devices().size(), probed.size());
    for (std::size_t k = 0; k < probed.size(); ++k) {
      if (k != i) {
        EXPECT_EQ(forced->devices()[k].state, DeviceState::kNotTried);
      }
    }
  }
  EXPECT_EQ(num_chosen, 1);
}

TEST_F(RenderCalls, SoftwareCanBeForced) {
  const std::unique_ptr<Renderer> renderer = make_renderer({.device = kSoftwareDevice});
  ASSERT_TRUE(renderer->available()) << renderer->description();
  EXPECT_NE(renderer->description().find("llvmpipe"), std::string::npos) << renderer->description();
}

TEST_F(RenderCalls, NoDeviceAndAnUnknownOneDrawNothing) {
  EXPECT_TRUE(check_device(kNoDevice).ok());
  EXPECT_EQ(make_renderer({.device = kNoDevice})->description(), "none: switched off");
  const Status status = check_device("abacus");
  EXPECT_EQ(status.reason, "UNKNOWN_DEVICE");
  EXPECT_NE(status.message.find(renderer_->devices().front().device.name), std::string::npos) << status.message;
  const std::unique_ptr<Renderer> renderer = make_renderer({.device = "abacus"});
  EXPECT_FALSE(renderer->available());
  EXPECT_NE(renderer->description().find("abacus"), std::string::npos) << renderer->description();
}

// The later platforms stand in where the first is missing, so they must be able to.
TEST_F(RenderCalls, EveryPlatformOfferedDrawsTheSheet) {
  const std::vector<EglPlatform> platforms = egl_platforms();
  ASSERT_FALSE(platforms.empty());
  const Sheet sheet = make_sheet(8, 0.2);
  const Scene scene = scene_of(sheet);
  for (const EglPlatform& platform : platforms) {
    std::thread([&] {  // a context belongs to one thread
      std::unique_ptr<Canvas> canvas;
      const Status made = make_gl_canvas(platform, canvas);
      ASSERT_TRUE(made.ok()) << made.message;
      EXPECT_NE(canvas->description().find("OpenGL"), std::string::npos) << canvas->description();
      if (platform.device.kind == DeviceKind::kSoftware) {
        EXPECT_TRUE(canvas->draws_in_software());
      }
      Pixels pixels;
      const Status drawn = canvas->draw(make_draw_list(scene, front_camera(), 320, 240), pixels, nullptr);
      ASSERT_TRUE(drawn.ok()) << drawn.message;
      EXPECT_TRUE(is_front(pixel(pixels, 163, 125))) << platform.device.name;
      EXPECT_EQ(pixel(pixels, 2, 2), kBackground) << platform.device.name;
    })
        .join();
  }
}

TEST_F(RenderCalls, SizesAreLimited) {
  const Sheet sheet = make_sheet(4, 0.0);
  const Scene scene = scene_of(sheet);
  for (const int side : {kMinImageSize, kMinImageSize + 1, kMaxImageSize - 1, kMaxImageSize}) {
    draw(scene, front_camera(), side, kMinImageSize);
    draw(scene, front_camera(), kMinImageSize, side);
  }
  Pixels pixels;
  pixels.width = 7;
  for (const int side : {kMinImageSize - 1, kMaxImageSize + 1, 0, -1}) {
    const Status wide = renderer_->render(scene, front_camera(), side, 64, pixels);
    EXPECT_EQ(wide.code, StatusCode::kInvalidArgument);
    EXPECT_EQ(wide.reason, "SIZE_OUT_OF_RANGE");
    EXPECT_EQ(wide.field, "width");
    const Status high = renderer_->render(scene, front_camera(), 64, side, pixels);
    EXPECT_EQ(high.reason, "SIZE_OUT_OF_RANGE");
    EXPECT_EQ(high.field, "height");
  }
  EXPECT_EQ(pixels.width, 7) << "a refused call must leave the pixels as they were";
}

TEST_F(RenderCalls, RefusesASingularCamera) {
  Camera camera = front_camera();
  camera.target = camera.eye;
  Pixels pixels;
  const Status status = renderer_->render(Scene{}, camera, 64, 64, pixels);
  EXPECT_EQ(status.code, StatusCode::kInvalidArgument);
  EXPECT_EQ(status.reason, "CAMERA_SINGULAR");
  EXPECT_EQ(status.field, "camera.target");
}

TEST_F(RenderCalls, ServesFourCallersAtOnce) {
  std::vector<Sheet> sheets;
  std::vector<Pixels> expected;
  for (int caller = 0; caller < 4; ++caller) {
    sheets.push_back(make_sheet(8, 0.1 * caller));
    expected.push_back(draw(scene_of(sheets.back()), front_camera(), 160 + 16 * caller, 120));
  }
  std::vector<int> wrong(4, 0);
  std::vector<std::thread> callers;
  for (std::size_t caller = 0; caller < 4; ++caller) {
    callers.emplace_back([&, caller] {
      for (int round = 0; round < 5; ++round) {
        Pixels pixels;
        const Status status =
            renderer_->render(scene_of(sheets[caller]), front_camera(), expected[caller].width, 120, pixels);
        if (!status.ok() || pixels.rgba != expected[caller].rgba) ++wrong[caller];
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(wrong, (std::vector<int>{0, 0, 0, 0}));
}

}  // namespace
}  // namespace kerf::render
