// Image streams: what is refused, and with which words.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/api/images_fixture.h"

namespace kerf::api {
namespace {

using ::testing::HasSubstr;

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
  EXPECT_EQ(fails(false, [](auto& v) { v.set_frame_rate(1.0, false); }), "START_MISSING start");
  EXPECT_EQ(fails(true, [](auto& v) { v.start("sheets/a"); }), "STARTED_TWICE start");
  EXPECT_EQ(fails(true, [](auto& v) { v.acknowledge(2); }), "ACK_OUT_OF_RANGE ack.sequence");
  EXPECT_EQ(fails(true, [](auto& v) { v.acknowledge(0); }), "ACK_OUT_OF_RANGE ack.sequence");
  EXPECT_EQ(fails(true, [](auto& v) { v.set_frame_rate(-1.0, false); }), "OUT_OF_RANGE pace.max_rate_hz");
  EXPECT_EQ(fails(true, [](auto& v) { v.acknowledge(1); }), "none") << "again: no error";
}

}  // namespace
}  // namespace kerf::api
