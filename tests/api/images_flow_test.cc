// Image streams: when a picture is sent, and when it is not drawn at all.

#include <gtest/gtest.h>

#include "tests/api/images_fixture.h"

namespace kerf::api {
namespace {

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
  viewer.set_frame_rate(0.0, false);
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
  viewer.set_frame_rate(0.0, true);
  run_for(20s);
  EXPECT_FALSE(viewer.next());
  EXPECT_FALSE(viewer.session().ended());
  EXPECT_EQ(rendered(), 1);
  viewer.set_frame_rate(0.0, false);
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
  viewer.set_frame_rate(0.0, true);
  renderer_.go.release(8);
  ImageViewer other(*api_);  // of the same view: what it is given was finished behind the other's
  start(other, "sheets/a");
  other.picture();
  EXPECT_FALSE(viewer.next());
  viewer.set_frame_rate(0.0, false);
  EXPECT_EQ(viewer.picture().sequence(), 1);
  EXPECT_EQ(rendered(), 1) << "from what was drawn before";
}

TEST_F(ImagesTest, AStalledStreamIsToldAndLetGo) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  ImageViewer viewer(*api_);
  start(viewer, "sheets/a", 1);
  ASSERT_TRUE(viewer.wait_for_message().has_image());
  run_for(10s - kTick);
  EXPECT_FALSE(viewer.next());
  run_for(kTick);
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

}  // namespace
}  // namespace kerf::api
