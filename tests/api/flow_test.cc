// Tests the requests of a stream besides frames: another pace, raw arrays, topology kept from an earlier stream; and
// the subscription without acknowledgements.

#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "kerf/v1/stream.pb.h"
#include "tests/api/fixture.h"
#include "tests/api/viewer.h"

namespace kerf::api {
namespace {

class FlowTest : public ApiTest {
 protected:
  v1::Frame first_frame(const v1::WatchStart& start) {
    Viewer viewer(*api_);
    v1::WatchRequest request;
    *request.mutable_start() = start;
    viewer.session().on_request(request);
    host_->wait_idle();
    const auto response = viewer.next();
    EXPECT_TRUE(response && response->has_frame()) << viewer.failure();
    return response ? response->frame() : v1::Frame();
  }
  std::string refusal(const v1::WatchRequest& request) {
    Viewer viewer(*api_);
    viewer.session().on_request(request);
    host_->wait_idle();
    const auto error = viewer.session().failure();
    return error ? error->reason + " " + error->field : "";
  }
};

TEST_F(FlowTest, ReconnectingViewerIsSentOnlyWhatItLacks) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::WatchStart start;
  start.set_name("sheets/a");
  const v1::Frame first = first_frame(start);
  EXPECT_EQ(first.topology().base_version(), -1);
  ASSERT_FALSE(first.epoch().empty());

  start.set_epoch(first.epoch());
  start.set_topology_version(first.topology_version());
  EXPECT_FALSE(first_frame(start).has_topology());
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  EXPECT_EQ(first_frame(start).topology().base_version(), first.topology_version());

  // Another sheet of the same name: its versions are others, though their numbers are the same.
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/DeleteSheet", R"({"name":"sheets/a"})").ok());
  ASSERT_TRUE(create_sheet("a", true).ok());
  const v1::Frame other = first_frame(start);
  EXPECT_EQ(other.topology().base_version(), -1);
  EXPECT_NE(other.epoch(), first.epoch());
}

TEST_F(FlowTest, StrainsOfAPausedSheetComeForWhoAsksLater) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  Viewer plain(*api_);
  plain.start("sheets/a");
  host_->wait_idle();
  ASSERT_TRUE(plain.drain());
  v1::WatchRequest request;
  request.mutable_start()->set_name("sheets/a");
  request.mutable_start()->set_strains(true);
  Viewer coloured(*api_);
  coloured.session().on_request(request);
  host_->wait_idle();
  while (coloured.drain()) host_->wait_idle();
  EXPECT_EQ(coloured.mirror.strains.size(), 49U);
  for (const float strain : coloured.mirror.strains) EXPECT_EQ(strain, 0.0F) << "at rest";
}

TEST_F(FlowTest, PausedStreamStaysOpenAndOwesNothing) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  v1::CreateCutRequest to_come = cut_request("sheets/a", 0.5);
  to_come.set_at_tick(1'000'000);  // so that the sheet does not sleep
  ASSERT_TRUE(call(&Api::create_cut, to_come).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a", 1);
  run_for(3 * kTick);
  ASSERT_TRUE(viewer.next()->has_frame());
  viewer.set_frame_rate(0.0, true);
  const std::int64_t snapshots = host_->metrics().snapshots;
  run_for(std::chrono::seconds(60));
  EXPECT_EQ(host_->metrics().snapshots, snapshots) << "nobody looks";
  EXPECT_FALSE(viewer.next());
  EXPECT_FALSE(viewer.session().ended());
  viewer.set_frame_rate(0.0, false);
  viewer.acknowledge(1);
  run_for(kTick);
  const auto response = viewer.next();
  ASSERT_TRUE(response && response->has_frame());
  EXPECT_GT(response->frame().stats().skipped(), 1000);
}

TEST_F(FlowTest, PaceChangesTheRate) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a");
  const auto frames_in_a_second = [&] {
    int frames = 0;
    for (int tick = 0; tick < 50; ++tick) {
      run_for(kTick);
      frames += viewer.drain() ? 1 : 0;
    }
    return frames;
  };
  EXPECT_GE(frames_in_a_second(), 49);
  viewer.set_frame_rate(5.0, false);
  EXPECT_NEAR(frames_in_a_second(), 5, 1);
  viewer.set_frame_rate(0.0, false);
  EXPECT_GE(frames_in_a_second(), 49);
}

// Behind its start at once, while the host has not yet let the stream join.
TEST_F(FlowTest, ThePaceMayComeBeforeTheFirstFrame) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a");
  viewer.set_frame_rate(5.0, false);
  viewer.set_frame_rate(5.0, true);
  EXPECT_FALSE(viewer.next());
  run_for(10 * kTick);
  EXPECT_FALSE(viewer.next());
  EXPECT_EQ(viewer.failure(), "");
  viewer.set_frame_rate(0.0, false);
  run_for(kTick);
  EXPECT_TRUE(viewer.drain());
}

TEST_F(FlowTest, SubscriptionSendsRawKeyframesUntilItsLast) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  v1::SubscribeRequest request;
  request.set_name("sheets/a");
  request.set_max_rate_hz(10.0);
  request.set_max_frames(4);
  Viewer reader(api_->subscribe(request));
  std::vector<v1::Frame> frames;
  for (int tick = 0; tick < 200 && !reader.session().ended(); ++tick) {
    run_for(kTick);
    while (const auto response = reader.next()) frames.push_back(response->frame());
  }
  EXPECT_TRUE(reader.session().ended());
  EXPECT_EQ(reader.failure(), "");
  ASSERT_EQ(frames.size(), 4U);
  for (const v1::Frame& frame : frames) {
    EXPECT_EQ(frame.encoding(), v1::RAW);
    EXPECT_EQ(frame.base_tick(), -1);
    EXPECT_EQ(reader.mirror.apply(frame), std::nullopt);
  }
  EXPECT_NEAR(static_cast<double>(frames[3].tick() - frames[2].tick()), 5.0, 1.0) << "10 a second of 50 ticks";
}

TEST_F(FlowTest, SubscriptionOwesNoAcknowledgementHoweverLong) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  v1::SubscribeRequest request;
  request.set_name("sheets/a");
  Viewer reader(api_->subscribe(request));
  int frames = 0;
  for (int second = 0; second < 20; ++second) {
    run_for(std::chrono::seconds(1));
    while (reader.next()) ++frames;
  }
  EXPECT_FALSE(reader.session().ended());
  EXPECT_NEAR(frames, 20, 2) << "one a second where no rate is asked for";
}

TEST_F(FlowTest, WhatIsOutOfRangeIsRefusedWithItsField) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::WatchRequest request;
  request.mutable_start()->set_name("sheets/a");
  const auto with = [&](const auto& spoil) {
    v1::WatchRequest spoilt = request;
    spoil(*spoilt.mutable_start());
    return refusal(spoilt);
  };
  EXPECT_EQ(refusal(request), "");
  EXPECT_EQ(with([](v1::WatchStart& s) { s.set_window(8); }), "");
  EXPECT_EQ(with([](v1::WatchStart& s) { s.set_window(9); }), "OUT_OF_RANGE start.window");
  EXPECT_EQ(with([](v1::WatchStart& s) { s.set_window(-1); }), "OUT_OF_RANGE start.window");
  EXPECT_EQ(with([](v1::WatchStart& s) { s.set_encoding(static_cast<v1::Encoding>(3)); }),
            "OUT_OF_RANGE start.encoding");
  EXPECT_EQ(with([](v1::WatchStart& s) { s.set_epoch(std::string(64, 'x')); }), "");
  EXPECT_EQ(with([](v1::WatchStart& s) { s.set_epoch(std::string(65, 'x')); }), "OUT_OF_RANGE start.epoch");
  EXPECT_EQ(with([](v1::WatchStart& s) {
              s.set_epoch("x");
              s.set_topology_version(std::numeric_limits<std::int32_t>::min());
            }),
            "");
  v1::WatchRequest early;
  early.mutable_pace()->set_paused(true);
  EXPECT_EQ(refusal(early), "START_MISSING start");

  for (const double rate : {-1.0, 1.0e-9, 2000.0, std::numeric_limits<double>::quiet_NaN()}) {
    Viewer viewer(*api_);
    viewer.start("sheets/a");
    host_->wait_idle();
    viewer.set_frame_rate(rate, false);
    EXPECT_EQ(viewer.failure(), "OUT_OF_RANGE") << rate;
  }
  Viewer viewer(*api_);
  viewer.start("sheets/a");
  host_->wait_idle();
  ASSERT_TRUE(viewer.next());
  viewer.acknowledge(1, std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(viewer.failure(), "") << "an absurd time is bounded";
  viewer.acknowledge(1, -1);
  EXPECT_EQ(viewer.failure(), "ACK_OUT_OF_RANGE");
}

TEST_F(FlowTest, RefusedSubscriptionsNameTheField) {
  const auto refusal_of = [&](const std::string& name, double rate_hz, std::int32_t max_frames) {
    v1::SubscribeRequest request;
    request.set_name(name);
    request.set_max_rate_hz(rate_hz);
    request.set_max_frames(max_frames);
    Viewer reader(api_->subscribe(request));
    host_->wait_idle();
    const auto error = reader.session().failure();
    return error ? error->reason + " " + error->field : "";
  };
  ASSERT_TRUE(create_sheet("a", true).ok());
  EXPECT_EQ(refusal_of("sheets/a", 10.0, 0), "");
  EXPECT_EQ(refusal_of("sheets/a", 10.1, 0), "OUT_OF_RANGE max_rate_hz");
  EXPECT_EQ(refusal_of("sheets/a", 0.0, -1), "OUT_OF_RANGE max_frames");
  EXPECT_EQ(refusal_of("sheets/b", 0.0, 0), "SHEET_NOT_FOUND name");
  EXPECT_EQ(refusal_of("demo", 0.0, 0), "NAME_MALFORMED name");
}

}  // namespace
}  // namespace kerf::api
