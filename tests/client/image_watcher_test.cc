// ImageWatcher, Watcher's pace and Sheet::watch_images() against a whole kerfd with its real renderer.

#include "client/cpp/image_watcher.h"

#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "client/cpp/server.h"
#include "tests/ws/running_server.h"

namespace kerf::client {
namespace {

class ImageWatcherTest : public testing::Test {
 protected:
  void SetUp() override {
    app::Config config = ws_test::test_config();
    config.render = true;
    running_ = ws_test::start_server(config);
    ASSERT_NE(running_, nullptr);
    server_ = std::make_unique<Server>(running_->grpc_address());
    const v1::ServerInfo info = server_->info().value();
    if (info.renderer().starts_with("none: ")) GTEST_SKIP() << info.renderer();
    video_ = info.video();
    v1::Scene scene = grid_scene(8, 8, 1.0, 1.0);
    pin(v1::Region::TOP, scene);
    ASSERT_TRUE(server_->create(scene, {"a", true, ""}).ok());
  }
  Sheet sheet() { return server_->sheet("a"); }
  static ImageOptions small() {
    ImageOptions options;
    options.look.width_px = 64;
    options.look.height_px = 48;
    return options;
  }

  std::unique_ptr<app::Server> running_;
  std::unique_ptr<Server> server_;
  bool video_ = false;
};

TEST_F(ImageWatcherTest, EachTickOfAPausedSheetIsSeen) {
  std::vector<std::int64_t> ticks;
  std::set<std::string> pictures;
  ImageOptions options = small();
  options.codec = v1::IMAGE_PNG;
  const Result<v1::Ended> ended = sheet().watch_images(
      [&](const v1::Image& image) {
        EXPECT_EQ(image.codec(), v1::IMAGE_PNG);
        EXPECT_EQ(image.width_px(), 64);
        EXPECT_EQ(image.data().substr(1, 3), "PNG");
        ticks.push_back(image.tick());
        pictures.insert(image.data());
        if (ticks.size() == 4) return false;
        EXPECT_TRUE(sheet().step(1).ok());
        return true;
      },
      options);
  ASSERT_TRUE(ended.ok()) << ended.failure().message;
  EXPECT_EQ(ticks, (std::vector<std::int64_t>{0, 1, 2, 3}));
  EXPECT_EQ(pictures.size(), 4U) << "it falls";
}

TEST_F(ImageWatcherTest, AnotherLookIsSeenFromTheNextPictureOn) {
  ImageWatcher watcher(server_->client());
  std::vector<int> widths;
  const grpc::Status status = watcher.run("sheets/a", small(), [&](const v1::Image& image) {
    widths.push_back(image.width_px());
    ImageLook look;
    look.width_px = 16 * (static_cast<int>(widths.size()) + 1);
    look.height_px = 48;
    look.color_by = v1::STRAINS;
    watcher.set_look(look);
    return widths.size() < 3;
  });
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(widths, (std::vector<int>{64, 32, 48}));
}

TEST_F(ImageWatcherTest, ColoursOfAPictureAreThoseAskedFor) {
  std::set<std::string> pictures;
  RenderOptions options;
  options.width_px = 64;
  options.height_px = 48;
  for (const v1::ColorBy by : {v1::SIDES, v1::PIECES, v1::STRAINS}) {
    options.color_by = by;
    pictures.insert(sheet().render(options).value().image());
  }
  EXPECT_EQ(pictures.size(), 3U);
}

TEST_F(ImageWatcherTest, VideoBeginsWithAKeyFrame) {
  ImageOptions options = small();
  options.codec = v1::IMAGE_VP8;
  std::vector<bool> keys;
  const Result<v1::Ended> ended = sheet().watch_images(
      [&](const v1::Image& image) {
        keys.push_back(image.key());
        if (keys.size() == 3) return false;
        EXPECT_TRUE(sheet().step(1).ok());
        return true;
      },
      options);
  if (!video_) {
    EXPECT_EQ(ended.failure().reason, "NO_VIDEO_CODEC");
    return;
  }
  ASSERT_TRUE(ended.ok()) << ended.failure().message;
  EXPECT_EQ(keys, (std::vector<bool>{true, false, false}));
}

// Settings made before run() hold from its first picture on: paused, nothing comes until the pause is over.
TEST_F(ImageWatcherTest, ThePaceMayBeSetBeforeAndFromAnotherThread) {
  ImageWatcher images(server_->client());
  Watcher frames(server_->client());
  images.set_pace(0.0, true);
  frames.set_pace(0.0, true);
  int num_images = 0;
  std::thread viewer(
      [&] { EXPECT_TRUE(images.run("sheets/a", small(), [&](const v1::Image&) { return ++num_images < 1; }).ok()); });
  images.set_pace(0.0);
  viewer.join();
  EXPECT_EQ(num_images, 1);
  std::int64_t tick = -1;
  std::thread watcher([&] {
    const auto on_frame = [&](const v1::Frame& frame, const Mirror&) {
      tick = frame.tick();
      return false;
    };
    const grpc::Status status = frames.run("sheets/a", {}, on_frame);
    EXPECT_TRUE(status.ok()) << status.error_message();
  });
  frames.set_pace(30.0);
  watcher.join();
  EXPECT_EQ(tick, 0);
}

TEST_F(ImageWatcherTest, ItEndsWithItsSheetOrWhenItIsStopped) {
  const Result<v1::Ended> ended = sheet().watch_images(
      [&](const v1::Image&) {
        EXPECT_TRUE(sheet().remove().ok());
        return true;
      },
      small());
  EXPECT_EQ(ended.value().reason(), v1::Ended::SHEET_DELETED);
  EXPECT_EQ(sheet().watch_images([](const v1::Image&) { return true; }).failure().reason, "SHEET_NOT_FOUND");

  ASSERT_TRUE(server_->create(grid_scene(4, 4, 1.0, 1.0), {"b", true, ""}).ok());
  ImageWatcher watcher(server_->client());
  int pictures = 0;
  const grpc::Status status = watcher.run("sheets/b", small(), [&](const v1::Image&) {
    ++pictures;
    watcher.stop();
    return true;
  });
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(pictures, 1);
  ImageOptions wrong = small();
  wrong.look.jpeg_quality = 101;
  EXPECT_EQ(server_->sheet("b").watch_images([](const v1::Image&) { return true; }, wrong).failure().field,
            "start.view.jpeg_quality");
}

}  // namespace
}  // namespace kerf::client
