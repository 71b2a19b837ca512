// Image streams: ImageSession as a transport sees it. What is drawn is counted: nothing in vain, nothing twice.

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/image.h"
#include "render/video.h"
#include "tests/api/api_fixture.h"
#include "tests/api/image_viewer.h"
#include "tests/api/picture_renderer.h"

namespace kerf::api {
namespace {

using ::testing::HasSubstr;

class ImagesTest : public ApiTest {
 protected:
  void SetUp() override {
    if (!render::image_codecs_available()) GTEST_SKIP() << "built without image libraries";
    make_api({}, &renderer_);
  }
  ~ImagesTest() override { api_.reset(); }  // before the renderer

  // Answered when the stream is joined to its sheet.
  void start(ImageViewer& viewer, const v1::WatchImagesRequest& request) {
    viewer.send(request);
    host_->wait_idle();
  }
  void start(ImageViewer& viewer, const std::string& name, int window = 0, double max_rate_hz = 0.0) {
    viewer.start(name, window, max_rate_hz);
    host_->wait_idle();
  }
  std::int64_t rendered() { return api_->picture_counts().rendered; }

  PictureRenderer renderer_;
};

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

TEST_F(ImagesTest, WhatASlowReaderSkipsIsNotDrawn) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  ImageViewer viewer(*api_);
  start(viewer, "sheets/a", 1);
  const v1::Image first = viewer.wait_for_message().image();
  for (int tick = 0; tick < 10; ++tick) {
    run_for(kTick);
    EXPECT_FALSE(viewer.next());
  }
  EXPECT_EQ(rendered(), 1);
  viewer.acknowledge(first.sequence());
  const v1::Image second = viewer.picture();
  EXPECT_EQ(second.tick(), get_sheet("sheets/a").tick()) << "the newest";
  EXPECT_EQ(second.stats().skipped(), second.tick() - first.tick() - 1);
  EXPECT_EQ(rendered(), 2);
  EXPECT_EQ(api_->picture_counts().skipped, second.stats().skipped());
}

TEST_F(ImagesTest, ThePaceIsKeptAndChanged) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  ImageViewer viewer(*api_);
  start(viewer, "sheets/a", 1, 10.0);
  const std::int64_t begun = viewer.picture().tick();
  for (int slot = 1; slot <= 3; ++slot) {  // 5 ticks each
    for (int tick = 0; tick < 4; ++tick) {
      run_for(kTick);
      EXPECT_FALSE(viewer.next());
    }
    run_for(kTick);
    EXPECT_EQ(viewer.picture().tick(), begun + 5 * slot);
  }
  viewer.pace(0.0, false);
  for (int tick = 16; tick < 20; ++tick) {
    run_for(kTick);
    EXPECT_EQ(viewer.picture().tick(), begun + tick);
  }
  EXPECT_EQ(rendered(), 8);
}

TEST_F(ImagesTest, APauseDrawsNothingAndOwesNothing) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  ImageViewer viewer(*api_);
  start(viewer, "sheets/a", 1);
  const v1::Image first = viewer.wait_for_message().image();
  viewer.pace(0.0, true);
  run_for(20s);
  EXPECT_FALSE(viewer.next());
  EXPECT_FALSE(viewer.session().ended());
  EXPECT_EQ(rendered(), 1);
  viewer.pace(0.0, false);
  viewer.acknowledge(first.sequence());
  EXPECT_EQ(viewer.picture().tick(), get_sheet("sheets/a").tick());
}

TEST_F(ImagesTest, APictureThatEndsInAPauseIsNotSent) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  renderer_.blocked = true;
  ImageViewer viewer(*api_);
  start(viewer, "sheets/a");
  EXPECT_FALSE(viewer.next());
  renderer_.started.acquire();
  viewer.pace(0.0, true);
  renderer_.go.release(8);
  ImageViewer other(*api_);  // of the same view: what it is given was finished behind the other's
  start(other, "sheets/a");
  other.picture();
  EXPECT_FALSE(viewer.next());
  viewer.pace(0.0, false);
  EXPECT_EQ(viewer.picture().sequence(), 1);
  EXPECT_EQ(rendered(), 1) << "from what was drawn before";
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

TEST_F(ImagesTest, AStalledStreamIsToldAndLetGo) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  ImageViewer viewer(*api_);
  start(viewer, "sheets/a", 1);
  ASSERT_TRUE(viewer.wait_for_message().has_image());
  run_for(10s - kTick);
  EXPECT_FALSE(viewer.next());
  EXPECT_FALSE(viewer.session().overdue());
  run_for(kTick);
  EXPECT_TRUE(viewer.session().overdue());
  const auto last = viewer.next();
  ASSERT_TRUE(last && last->has_ended());
  EXPECT_EQ(last->ended().reason(), v1::Ended::TOO_SLOW);
  EXPECT_TRUE(viewer.session().ended());
  EXPECT_EQ(viewer.failure(), "") << "no failure: it was told";
  EXPECT_EQ(api_->picture_counts().streams, 0) << "without waiting for the transport";
  host_->wait_idle();
  EXPECT_EQ(host_->metrics().sinks, 0);
  EXPECT_FALSE(viewer.next());
}

TEST_F(ImagesTest, TheNumberOfStreamsIsLimited) {
  Limits limits;
  limits.max_image_streams = 2;
  make_api(limits, &renderer_);
  ASSERT_TRUE(create_sheet("a", true).ok());
  ImageViewer first(*api_);
  ImageViewer second(*api_);
  ImageViewer third(*api_);
  start(first, "sheets/a");
  start(second, "sheets/a");
  start(third, "sheets/a");
  EXPECT_EQ(third.failure(), "TOO_MANY_IMAGE_STREAMS");
  EXPECT_EQ(third.session().failure()->code, ErrorCode::kResourceExhausted);
  EXPECT_THAT(third.session().failure()->message, HasSubstr("2"));
  first.session().close();
  ImageViewer fourth(*api_);
  start(fourth, "sheets/a");
  fourth.picture();
  second.picture();
  EXPECT_EQ(api_->picture_counts().streams, 2);
}

TEST_F(ImagesTest, TheEndOfASheetAndOfTheServerIsTold) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(create_sheet("b", true).ok());
  ImageViewer of_a(*api_);
  ImageViewer of_b(*api_);
  ImageViewer unstarted(*api_);
  start(of_a, "sheets/a");
  start(of_b, "sheets/b");
  of_a.picture();
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/DeleteSheet", R"({"name":"sheets/a"})").ok());
  EXPECT_EQ(of_a.wait_for_message().ended().reason(), v1::Ended::SHEET_DELETED);
  api_->stop();
  EXPECT_EQ(of_b.wait_for_message().ended().reason(), v1::Ended::SERVER_STOPPING);
  EXPECT_EQ(unstarted.failure(), "SERVER_STOPPING");
}

TEST_F(ImagesTest, APlayerOwesNoAcknowledgements) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  ImageViewer viewer(api_->play_images(ImageViewer::start_of("sheets/a").start()));
  host_->wait_idle();
  const std::int64_t begun = get_sheet("sheets/a").tick();
  for (int tick = 0; tick < 20; ++tick) {
    EXPECT_EQ(viewer.wait_for_message().image().tick(), begun + tick);
    run_for(kTick);
  }
  run_for(20s);
  EXPECT_FALSE(viewer.session().ended());
  ImageViewer nobody(api_->play_images(ImageViewer::start_of("sheets/nobody").start()));
  host_->wait_idle();
  EXPECT_EQ(nobody.failure(), "SHEET_NOT_FOUND");
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

TEST_F(ImagesTest, BadStartsAndViewsNameTheirFieldAndItsRange) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  struct Bad {
    std::function<void(v1::WatchImagesStart&)> spoil;
    const char* field;  // "" where it is allowed
    const char* says;
  };
  const std::vector<Bad> bad = {
      {[](auto& s) { s.set_name("a"); }, "start.name", "sheets/"},
      {[](auto& s) { s.set_name("sheets/nobody"); }, "start.name", "nobody"},
      {[](auto& s) { s.set_window(-1); }, "start.window", "1 to 8"},
      {[](auto& s) { s.set_window(9); }, "start.window", "1 to 8"},
      {[](auto& s) { s.set_window(8); }, "", ""},
      {[](auto& s) { s.set_max_rate_hz(0.0009); }, "start.max_rate_hz", "0.001 to 1000"},
      {[](auto& s) { s.set_max_rate_hz(1000.1); }, "start.max_rate_hz", "0.001 to 1000"},
      {[](auto& s) { s.set_max_rate_hz(1000.0); }, "", ""},
      {[](auto& s) { s.set_codec(static_cast<v1::ImageCodec>(4)); }, "start.codec", "IMAGE_VP8 (3)"},
      {[](auto& s) { s.mutable_view()->set_width_px(15); }, "start.view.width_px", "16 to 4096"},
      {[](auto& s) { s.mutable_view()->set_width_px(16); }, "", ""},
      {[](auto& s) { s.mutable_view()->set_height_px(4097); }, "start.view.height_px", "16 to 4096"},
      {[](auto& s) { s.mutable_view()->set_height_px(4096); }, "", ""},
      {[](auto& s) { s.mutable_view()->set_jpeg_quality(101); }, "start.view.jpeg_quality", "1 to 100"},
      {[](auto& s) { s.mutable_view()->set_jpeg_quality(100); }, "", ""},
      {[](auto& s) { s.mutable_view()->set_bitrate_kbps(49); }, "start.view.bitrate_kbps", "50 to 50000"},
      {[](auto& s) { s.mutable_view()->set_bitrate_kbps(50001); }, "start.view.bitrate_kbps", "50 to 50000"},
      {[](auto& s) { s.mutable_view()->set_color_by(static_cast<v1::ColorBy>(7)); }, "start.view.color_by", "STRAINS"},
      {[](auto& s) { s.mutable_view()->mutable_camera(); }, "start.view.camera.target", "eye"},
      {[](auto& s) { s.mutable_view()->mutable_camera()->set_vertical_fov_deg(0.5); },
       "start.view.camera.vertical_fov_deg", "179"},
  };
  for (std::size_t i = 0; i < bad.size(); ++i) {
    v1::WatchImagesRequest request = ImageViewer::start_of("sheets/a");
    if (std::string(bad[i].field).ends_with("_deg"))
      request.mutable_start()->mutable_view()->mutable_camera()->mutable_eye()->set_x(1);
    bad[i].spoil(*request.mutable_start());
    ImageViewer viewer(*api_);
    start(viewer, request);
    const std::optional<Error> failure = viewer.session().failure();
    ASSERT_EQ(failure.has_value(), *bad[i].field != '\0') << i << (failure ? failure->message : "");
    if (!failure) continue;
    EXPECT_EQ(failure->field, bad[i].field) << i;
    EXPECT_THAT(failure->message, HasSubstr(bad[i].says)) << i;
  }
  ImageViewer viewer(*api_);
  start(viewer, "sheets/a");
  v1::ImageView view;
  view.set_height_px(15);
  viewer.look(view);
  EXPECT_EQ(viewer.session().failure()->field, "view.height_px");
}

TEST_F(ImagesTest, WhatIsNoProtocolIsRefused) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  const auto fails = [&](bool starts, const std::function<void(ImageViewer&)>& spoil) {
    ImageViewer viewer(*api_);
    if (starts) {
      start(viewer, "sheets/a");
      viewer.picture();
    }
    spoil(viewer);
    const std::optional<Error> failure = viewer.session().failure();
    return failure ? failure->reason + " " + failure->field : "none";
  };
  EXPECT_EQ(fails(false, [](auto& v) { v.session().on_bytes("\xff\xff\xff"); }), "MALFORMED_MESSAGE ");
  EXPECT_EQ(fails(false, [](auto& v) { v.session().on_bytes(""); }), "CHOICE_MISSING kind");
  EXPECT_EQ(fails(false, [](auto& v) { v.acknowledge(1); }), "START_MISSING start");
  EXPECT_EQ(fails(false, [](auto& v) { v.pace(1.0, false); }), "START_MISSING start");
  EXPECT_EQ(fails(true, [](auto& v) { v.start("sheets/a"); }), "STARTED_TWICE start");
  EXPECT_EQ(fails(true, [](auto& v) { v.acknowledge(2); }), "ACK_OUT_OF_RANGE ack.sequence");
  EXPECT_EQ(fails(true, [](auto& v) { v.acknowledge(0); }), "ACK_OUT_OF_RANGE ack.sequence");
  EXPECT_EQ(fails(true, [](auto& v) { v.pace(-1.0, false); }), "OUT_OF_RANGE pace.max_rate_hz");
  EXPECT_EQ(fails(true, [](auto& v) { v.acknowledge(1); }), "none") << "again: no error";
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
