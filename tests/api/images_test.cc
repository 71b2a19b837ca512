// Image streams: ImageSession as a transport sees it. What is drawn is counted: nothing in vain, nothing twice.

#include <cstdint>
#include <future>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "render/video.h"
#include "server/service/picture/picture_studio.h"
#include "tests/api/images_fixture.h"

namespace kerf::api {
namespace {

TEST_F(ImagesTest, APausedSheetIsShownAtOnce) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ImageViewer viewer(*api_);
  start(viewer, "sheets/a");
  const v1::Image image = viewer.picture();
  EXPECT_EQ(image.sequence(), 1);
  EXPECT_EQ(image.tick(), 0);
  EXPECT_EQ(image.codec(), v1::IMAGE_JPEG);
  EXPECT_TRUE(image.key());
  EXPECT_EQ(image.width_px(), 32);
  EXPECT_EQ(image.height_px(), 16);
  EXPECT_EQ(image.data().substr(0, 2), "\xff\xd8");
  EXPECT_EQ(image.camera().vertical_fov_deg(), 40.0);
  EXPECT_EQ(image.camera().up().z(), 1.0);
  EXPECT_EQ(image.camera().eye().x(), renderer_.eyes().at(0)) << "the camera that was chosen";
  EXPECT_TRUE(image.stats().paused());
  EXPECT_EQ(image.stats().num_triangles(), 72);
  EXPECT_FALSE(viewer.next()) << "once";
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  EXPECT_EQ(viewer.picture().stats().pieces(), 2) << "cut while paused: shown although the tick is the same";
  EXPECT_EQ(rendered(), 2);
}

TEST_F(ImagesTest, EqualViewsAreDrawnAndEncodedOnce) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  run_for(kTick);
  std::vector<std::unique_ptr<ImageViewer>> viewers;
  for (int i = 0; i < 5; ++i) {
    viewers.push_back(std::make_unique<ImageViewer>(*api_));
    start(*viewers.back(), "sheets/a");
  }
  v1::WatchImagesRequest coarse = ImageViewer::start_of("sheets/a");
  coarse.mutable_start()->mutable_view()->set_jpeg_quality(20);
  viewers.push_back(std::make_unique<ImageViewer>(*api_));
  start(*viewers.back(), coarse);
  constexpr int kTicks = 3;
  const std::int64_t begun = get_sheet("sheets/a").tick();
  for (int tick = 0; tick < kTicks; ++tick) {
    std::string data;
    for (std::size_t i = 0; i < 5; ++i) {
      const v1::Image image = viewers[i]->picture();
      EXPECT_EQ(image.tick(), begun + tick);
      EXPECT_TRUE(i == 0 || image.data() == data);
      data = image.data();
    }
    EXPECT_NE(viewers[5]->picture().data(), data);
    run_for(kTick);
  }
  const PictureCounts counts = api_->picture_counts();
  EXPECT_EQ(counts.rendered, kTicks) << "one for all six";
  EXPECT_EQ(counts.encoded, 2 * kTicks) << "one for each quality";
  EXPECT_EQ(counts.shared, 4 * kTicks);
  EXPECT_EQ(counts.sent, 6 * kTicks);
  EXPECT_EQ(counts.skipped, 0);
  EXPECT_EQ(counts.streams, 6);
}

TEST_F(ImagesTest, OnlyTheLastFormatsOfAPictureAreKept) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ImageViewer viewer(*api_);
  start(viewer, "sheets/a");
  viewer.picture();
  v1::ImageView view = ImageViewer::start_of("sheets/a").start().view();
  const auto encoded_for = [&](int quality) {
    const std::int64_t before = api_->picture_counts().encoded;
    view.set_jpeg_quality(quality);
    viewer.look(view);
    viewer.picture();
    return api_->picture_counts().encoded - before;
  };
  constexpr int kKept = static_cast<int>(picture::kMaxKeptStills);
  for (int quality = 1; quality <= kKept; ++quality) EXPECT_EQ(encoded_for(quality), 1);
  for (int quality = 1; quality <= kKept; ++quality) EXPECT_EQ(encoded_for(quality), 0) << "kept";
  EXPECT_EQ(encoded_for(kKept + 1), 1);
  EXPECT_EQ(encoded_for(2), 0);
  EXPECT_EQ(encoded_for(1), 1) << "the oldest was let go";
  EXPECT_EQ(rendered(), 1);
}

TEST_F(ImagesTest, WhoeverComesWhileAPictureIsDrawnSharesIt) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  renderer_.blocked = true;
  ImageViewer first(*api_);
  ImageViewer second(*api_);
  start(first, "sheets/a");
  start(second, "sheets/a");
  EXPECT_FALSE(first.next());
  renderer_.started.acquire();
  EXPECT_FALSE(second.next());
  renderer_.go.release(8);
  EXPECT_EQ(first.picture().data(), second.picture().data());
  EXPECT_EQ(rendered(), 1);
}

TEST_F(ImagesTest, NothingIsDrawnForNobody) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  run_for(10 * kTick);
  EXPECT_EQ(host_->metrics().snapshots, 0);
  {
    ImageViewer viewer(*api_);
    start(viewer, "sheets/a");
    viewer.picture();
    viewer.session().close();
  }
  host_->wait_idle();
  EXPECT_EQ(host_->metrics().sinks, 0);
  const std::int64_t snapshots = host_->metrics().snapshots;
  run_for(10 * kTick);
  EXPECT_EQ(host_->metrics().snapshots, snapshots);
  EXPECT_EQ(rendered(), 1);
  EXPECT_EQ(api_->picture_counts().streams, 0);
}

TEST_F(ImagesTest, AViewHoldsFromTheNextPictureOn) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ImageViewer viewer(*api_);
  start(viewer, "sheets/a");
  viewer.picture();
  v1::ImageView view;
  view.set_width_px(48);
  view.set_height_px(24);
  view.mutable_camera()->mutable_eye()->set_x(3.0);
  view.mutable_camera()->mutable_target();
  viewer.look(view);
  const v1::Image image = viewer.picture();
  EXPECT_EQ(image.width_px(), 48);
  EXPECT_EQ(image.camera().eye().x(), 3.0);
  EXPECT_EQ(image.tick(), 0);
  view.mutable_camera()->mutable_eye()->set_x(4.0);
  viewer.look(view);
  EXPECT_EQ(viewer.picture().camera().eye().x(), 4.0);
  EXPECT_EQ(rendered(), 3);
}

TEST_F(ImagesTest, AFlatViewIsDrawnOnceATopology) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  v1::WatchImagesRequest request = ImageViewer::start_of("sheets/a");
  request.mutable_start()->mutable_view()->set_undeformed(true);
  ImageViewer viewer(*api_);
  start(viewer, request);
  for (int tick = 0; tick < 5; ++tick) {
    viewer.picture();
    run_for(kTick);
  }
  EXPECT_EQ(rendered(), 1) << "it does not move";
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  EXPECT_EQ(viewer.picture().stats().pieces(), 2);
  EXPECT_EQ(rendered(), 2);
}

TEST_F(ImagesTest, StrainsAndPiecesAreColoured) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  ImageViewer viewer(*api_);
  start(viewer, "sheets/a");
  viewer.picture();
  EXPECT_TRUE(renderer_.colours().empty()) << "the sides' own";
  EXPECT_TRUE(host_->metrics().snapshots > 0);
  v1::ImageView view = ImageViewer::start_of("sheets/a").start().view();
  view.set_color_by(v1::STRAINS);
  run_for(10 * kTick);
  viewer.look(view);
  host_->wait_idle();  // a snapshot with strains is published
  viewer.picture();
  const std::vector<std::uint8_t> strains = renderer_.colours();
  ASSERT_FALSE(strains.empty());
  EXPECT_NE(strains, std::vector<std::uint8_t>(strains.size(), strains[0])) << "it hangs, and is stretched above";
  view.set_color_by(v1::PIECES);
  viewer.look(view);
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  while (viewer.picture().stats().pieces() != 2) {
  }
  std::set<std::vector<std::uint8_t>> colours;
  const std::vector<std::uint8_t> pieces = renderer_.colours();
  for (std::size_t i = 0; i + 2 < pieces.size(); i += 3) colours.insert({pieces.begin() + i, pieces.begin() + i + 3});
  EXPECT_EQ(colours.size(), 2U);
}

TEST_F(ImagesTest, ARendererThatFailsEndsTheStreamWithItsReason) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  renderer_.refusal = true;
  ImageViewer viewer(*api_);
  start(viewer, "sheets/a");
  EXPECT_EQ(viewer.wait_for_failure(), "CONTEXT_LOST");
  EXPECT_EQ(api_->picture_counts().streams, 0);
  make_api({}, nullptr);
  ImageViewer without(*api_);
  start(without, "sheets/a");
  EXPECT_EQ(without.failure(), "RENDERER_UNAVAILABLE");
}

TEST_F(ImagesTest, APictureForWhichThereIsNoMemoryEndsItsStreamAndIsTheAnswerOfItsCall) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  renderer_.poor = true;
  ImageViewer viewer(*api_);
  start(viewer, "sheets/a");
  EXPECT_EQ(viewer.wait_for_failure(), "OUT_OF_MEMORY");
  v1::RenderImageRequest request;
  request.set_name("sheets/a");
  std::promise<Result<v1::RenderImageResponse>> promise;
  api_->render_image(request,
                     [&promise](Result<v1::RenderImageResponse> reply) { promise.set_value(std::move(reply)); });
  EXPECT_EQ(promise.get_future().get().error().reason, "OUT_OF_MEMORY");
  renderer_.poor = false;
  ImageViewer other(*api_);
  start(other, "sheets/a");
  other.picture();
}

TEST_F(ImagesTest, VideoBeginsWithAKeyFrameAndAfterWhatBreaksIt) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  v1::WatchImagesRequest request = ImageViewer::start_of("sheets/a");
  request.mutable_start()->set_codec(v1::IMAGE_VP8);
  ImageViewer viewer(*api_);
  start(viewer, request);
  if (!render::video_available()) {
    EXPECT_EQ(viewer.failure(), "NO_VIDEO_CODEC");
    return;
  }
  const auto next_is_key = [&] {
    const v1::Image image = viewer.picture();
    EXPECT_EQ(image.codec(), v1::IMAGE_VP8);
    EXPECT_EQ(render::is_key_frame({reinterpret_cast<const std::uint8_t*>(image.data().data()), image.data().size()}),
              image.key());
    run_for(kTick);
    return image.key();
  };
  EXPECT_TRUE(next_is_key());
  EXPECT_FALSE(next_is_key());
  v1::ImageView view = request.start().view();
  viewer.look(view);  // the same: the reader has lost its place
  EXPECT_TRUE(next_is_key());
  EXPECT_FALSE(next_is_key());
  view.mutable_camera()->mutable_eye()->set_x(3.0);
  viewer.look(view);
  EXPECT_FALSE(next_is_key()) << "another camera is another frame";
  view.set_width_px(64);
  viewer.look(view);
  EXPECT_TRUE(next_is_key()) << "another size is another stream";
  ImageViewer joiner(*api_);
  start(joiner, request);
  EXPECT_TRUE(joiner.picture().key());
  view.set_width_px(4096);
  view.set_height_px(563);
  viewer.look(view);
  EXPECT_EQ(viewer.session().failure()->field, "view.width_px") << "more pixels than VP8 may have";
}

}  // namespace
}  // namespace kerf::api
