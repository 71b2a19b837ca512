// Streams: WatchSession as a transport sees it.

#include <cmath>
#include <cstring>
#include <functional>

#include <gtest/gtest.h>

#include "kerf/v1/stream.pb.h"
#include "server/service/wire/protobuf_log.h"
#include "tests/api/fixture.h"
#include "tests/api/viewer.h"
#include "tests/wire/frame_mirror.h"

namespace kerf::api {
namespace {

using kerf::testing::FrameMirror;

class WatchTest : public ApiTest {
 protected:
  // Compares with GetSheetState, in the quanta of the mirror's box.
  void expect_equal_to_server(const FrameMirror& mirror, const std::string& name) {
    v1::GetSheetStateRequest request;
    request.set_name(name);
    const v1::SheetState state = call(&Api::get_sheet_state, request).value();
    ASSERT_EQ(mirror.tick, state.tick());
    ASSERT_EQ(mirror.quantised.size(), 3 * static_cast<std::size_t>(state.num_vertices()));
    for (std::size_t i = 0; i < mirror.quantised.size(); ++i) {
      double exact = 0.0;
      std::memcpy(&exact, state.positions().data() + 8 * i, 8);
      const double size = mirror.box_max[i % 3] - mirror.box_min[i % 3];
      ASSERT_EQ(mirror.quantised[i], std::floor((exact - mirror.box_min[i % 3]) * (65535.0 / size) + 0.5));
    }
    ASSERT_EQ(state.triangles().size(), 12 * mirror.triangles.size());
    EXPECT_EQ(std::memcmp(state.triangles().data(), mirror.triangles.data(), state.triangles().size()), 0);
    EXPECT_EQ(std::memcmp(state.pieces().data(), mirror.pieces.data(), state.pieces().size()), 0);
  }

  // Ids of the grabs that hold sheet `id` now.
  std::vector<std::string> grabs(const std::string& id) {
    std::vector<std::string> ids;
    host_->inspect(
        id,
        [&ids](const sheet::Sheet& sheet) {
          for (const sheet::GrabState& grab : sheet.grabs()) ids.push_back(grab.grab_id);
        },
        [](const Status&) {});
    host_->wait_idle();
    return ids;
  }
};

TEST_F(WatchTest, PausedSheetIsShownAtOnce) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a");
  host_->wait_idle();
  EXPECT_GT(viewer.woken(), 0);
  ASSERT_TRUE(viewer.drain());
  expect_equal_to_server(viewer.mirror, "sheets/a");
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  ASSERT_TRUE(viewer.drain()) << "cut while paused: shown although the tick is the same";
  expect_equal_to_server(viewer.mirror, "sheets/a");
}

TEST_F(WatchTest, MirrorEqualsTheServerThroughTicksCutsAndReset) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a", 2);
  for (int round = 0; round < 40; ++round) {
    run_for((1 + round % 3) * kTick);
    if (round % 4 == 3) {
      ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.07 + 0.021 * round)).ok());
    }
    if (round == 30) {
      ASSERT_TRUE(call_json("/kerf.v1.SheetService/ResetSheet", R"({"name":"sheets/a"})").ok());
    }
    viewer.drain();
    expect_equal_to_server(viewer.mirror, "sheets/a");
    if (HasFatalFailure()) return;
  }
}

TEST_F(WatchTest, CutIsInTheFirstFrameOfItsTick) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a");
  run_for(3 * kTick);
  viewer.drain();
  Answers<v1::CutResult> answers;
  api_->create_cut(cut_request("sheets/a", 0.45), answers.callback());
  while (answers.count() == 0) {
    run_for(kTick);
    ASSERT_TRUE(viewer.drain());
  }
  EXPECT_EQ(viewer.mirror.tick, answers.at(0)->tick());
  EXPECT_EQ(viewer.mirror.topology_version, answers.at(0)->topology_version());
}

TEST_F(WatchTest, NothingIsBuiltForNobody) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  run_for(20 * kTick);
  EXPECT_EQ(host_->metrics().snapshots, 0);
  {
    Viewer viewer(*api_);
    viewer.start("sheets/a");
    run_for(5 * kTick);
    EXPECT_EQ(api_->num_watchers(), 1);
    viewer.session().close();
  }
  host_->wait_idle();
  const std::int64_t snapshots = host_->metrics().snapshots;
  EXPECT_GT(snapshots, 0);
  run_for(20 * kTick);
  EXPECT_EQ(host_->metrics().snapshots, snapshots);
  EXPECT_EQ(host_->metrics().sinks, 0) << "the last viewer takes the channel with it";
  EXPECT_EQ(api_->num_watchers(), 0);
}

TEST_F(WatchTest, ViewersComeAndGo) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  for (int round = 0; round < 20; ++round) {
    Viewer first(*api_);
    Viewer second(*api_);
    first.start("sheets/a");
    second.start("sheets/a");
    if (round % 3 == 0) first.session().close();  // before it was joined, perhaps
    run_for(kTick);
    ASSERT_TRUE(second.drain());
    EXPECT_EQ(second.mirror.tick, get_sheet("sheets/a").tick());
  }
  host_->wait_idle();
  EXPECT_EQ(host_->metrics().sinks, 0);
}

TEST_F(WatchTest, SlowReaderGetsOnlyTheNewest) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a", 1);
  run_for(kTick);
  auto response = viewer.next();
  ASSERT_TRUE(response);
  ASSERT_EQ(viewer.mirror.apply(response->frame()), std::nullopt);
  run_for(50 * kTick);
  EXPECT_FALSE(viewer.next()) << "the window is closed";
  viewer.acknowledge(1);
  response = viewer.next();
  ASSERT_TRUE(response);
  EXPECT_EQ(response->frame().tick(), get_sheet("sheets/a").tick());
  EXPECT_EQ(response->frame().stats().skipped(), response->frame().tick() - viewer.mirror.tick - 1);
}

TEST_F(WatchTest, RateIsKeptWithATimer) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a", 2, 10.0);
  run_for(kTick);
  int frames = 0;
  int woken = -1;
  for (int tick = 0; tick < 500; ++tick) {  // ten seconds
    run_for(kTick);
    if (viewer.woken() == woken) continue;  // A transport calls next() only when woken.
    woken = viewer.woken();
    frames += viewer.drain() ? 1 : 0;
  }
  EXPECT_NEAR(frames, 100, 2);
}

TEST_F(WatchTest, TheSlowestRateIsAFrameInAThousandSeconds) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a", 2, 1e-3);
  host_->wait_idle();
  ASSERT_TRUE(viewer.drain());
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  run_for(999s);
  EXPECT_FALSE(viewer.drain());
  run_for(1s);
  EXPECT_TRUE(viewer.drain());
}

TEST_F(WatchTest, LastFrameOfASleepingSheetIsNotHeldBackByTheRate) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a", 2, 1.0);
  host_->wait_idle();
  ASSERT_TRUE(viewer.drain());
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  EXPECT_FALSE(viewer.drain()) << "too soon";
  const int woken = viewer.woken();
  run_for(1s);
  EXPECT_GT(viewer.woken(), woken) << "by a timer: the paused sheet publishes nothing more";
  EXPECT_TRUE(viewer.drain());
  EXPECT_EQ(viewer.mirror.topology_version, 2);
}

TEST_F(WatchTest, SilenceEndsTheStream) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a");
  host_->wait_idle();
  ASSERT_TRUE(viewer.next());
  EXPECT_FALSE(viewer.next());
  int woken = viewer.woken();
  run_for(9999ms);
  EXPECT_EQ(viewer.woken(), woken);
  run_for(1ms);
  EXPECT_GT(viewer.woken(), woken);
  const auto response = viewer.next();
  ASSERT_TRUE(response);
  EXPECT_EQ(response->ended().reason(), v1::Ended::TOO_SLOW);
  EXPECT_TRUE(viewer.session().ended());
  EXPECT_FALSE(viewer.session().failure());
  EXPECT_FALSE(viewer.next());
}

TEST_F(WatchTest, DeletionIsToldAndTheNameCanBeUsedAgain) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a");
  run_for(kTick);
  viewer.drain();
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/DeleteSheet", R"({"name":"sheets/a"})").ok());
  viewer.drain();
  ASSERT_EQ(viewer.others.size(), 1U);
  EXPECT_EQ(viewer.others[0].ended().reason(), v1::Ended::SHEET_DELETED);
  EXPECT_TRUE(viewer.session().ended());
  ASSERT_TRUE(create_sheet("a", true).ok());
  Viewer again(*api_);
  again.start("sheets/a");
  host_->wait_idle();
  EXPECT_TRUE(again.drain());
  viewer.session().close();
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  EXPECT_TRUE(again.drain()) << "the old viewer's leaving took nothing from the new one";
}

TEST_F(WatchTest, StopEndsEveryStream) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  Viewer watching(*api_);
  Viewer waiting(*api_);
  watching.start("sheets/a");
  host_->wait_idle();
  watching.drain();
  api_->stop();
  watching.drain();
  ASSERT_EQ(watching.others.size(), 1U);
  EXPECT_EQ(watching.others[0].ended().reason(), v1::Ended::SERVER_STOPPING);
  EXPECT_TRUE(waiting.session().ended());
  EXPECT_EQ(waiting.session().failure()->code, ErrorCode::kUnavailable);
  Viewer late(*api_);
  late.start("sheets/a");
  EXPECT_EQ(late.session().failure()->code, ErrorCode::kUnavailable);
}

TEST_F(WatchTest, WhatBreaksTheProtocolEndsOnlyItsStream) {
  wire::discard_protobuf_log();
  ASSERT_TRUE(create_sheet("a", true).ok());
  Viewer good(*api_);
  good.start("sheets/a");
  const auto refused = [&](const std::function<void(Viewer&)>& act, const char* reason, ErrorCode code) {
    Viewer viewer(*api_);
    act(viewer);
    host_->wait_idle();
    EXPECT_EQ(viewer.failure(), reason);
    ASSERT_TRUE(viewer.session().failure());
    EXPECT_EQ(viewer.session().failure()->code, code) << reason;
    EXPECT_TRUE(viewer.session().ended());
    EXPECT_FALSE(viewer.next());
    EXPECT_GT(viewer.woken(), 0) << reason;
  };
  const ErrorCode invalid = ErrorCode::kInvalidArgument;
  refused([](Viewer& v) { v.acknowledge(1); }, "START_MISSING", invalid);
  refused([](Viewer& v) { v.grab("g", 0); }, "START_MISSING", invalid);
  refused([](Viewer& v) { v.session().on_request({}); }, "CHOICE_MISSING", invalid);
  refused([](Viewer& v) { v.session().on_bytes("\xff\xff\xff"); }, "MALFORMED_MESSAGE", invalid);
  refused([](Viewer& v) { v.start("sheets/nobody"); }, "SHEET_NOT_FOUND", ErrorCode::kNotFound);
  refused([](Viewer& v) { v.start("a"); }, "NAME_MALFORMED", invalid);
  refused([](Viewer& v) { v.start("sheets/a", 9); }, "OUT_OF_RANGE", invalid);
  refused([](Viewer& v) { v.start("sheets/a", -1); }, "OUT_OF_RANGE", invalid);
  refused([](Viewer& v) { v.start("sheets/a", 2, -1.0); }, "OUT_OF_RANGE", invalid);
  refused([](Viewer& v) { v.start("sheets/a", 2, 1e-300); }, "OUT_OF_RANGE", invalid);
  refused([](Viewer& v) { v.start("sheets/a", 2, std::nextafter(1e-3, 0.0)); }, "OUT_OF_RANGE", invalid);
  refused([](Viewer& v) { v.start("sheets/a", 2, 1000.1); }, "OUT_OF_RANGE", invalid);
  refused([](Viewer& v) { v.start("sheets/a", 2, std::nan("")); }, "OUT_OF_RANGE", invalid);
  refused(
      [](Viewer& v) {
        v.start("sheets/a");
        v.start("sheets/a");
      },
      "STARTED_TWICE", invalid);
  refused(
      [this](Viewer& v) {
        v.start("sheets/a");
        host_->wait_idle();
        v.acknowledge(1);
      },
      "ACK_OUT_OF_RANGE", invalid);
  EXPECT_TRUE(good.drain());
  EXPECT_EQ(good.failure(), "");
}

TEST_F(WatchTest, SubscribersOfASheetAreBounded) {
  Limits limits;
  limits.max_subscribers_per_sheet = 2;
  make_api(limits, nullptr);
  ASSERT_TRUE(create_sheet("a", true).ok());
  Viewer first(*api_);
  Viewer second(*api_);
  Viewer third(*api_);
  for (Viewer* viewer : {&first, &second, &third}) viewer->start("sheets/a");
  host_->wait_idle();
  EXPECT_TRUE(first.drain());
  EXPECT_TRUE(second.drain());
  EXPECT_EQ(third.failure(), "TOO_MANY_SUBSCRIBERS");
  first.session().close();
  Viewer fourth(*api_);
  fourth.start("sheets/a");
  host_->wait_idle();
  EXPECT_TRUE(fourth.drain());
}

TEST_F(WatchTest, GrabsEndWithTheirStream) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a");
  viewer.grab("one", 3);
  viewer.grab("two", 5);
  run_for(2 * kTick);
  EXPECT_EQ(grabs("a"), (std::vector<std::string>{"one", "two"}));
  viewer.release("one");
  run_for(2 * kTick);
  EXPECT_EQ(grabs("a"), std::vector<std::string>{"two"});
  viewer.session().close();
  run_for(2 * kTick);
  EXPECT_TRUE(grabs("a").empty());
}

TEST_F(WatchTest, GrabsEndWithAStreamThatFilledTheQueue) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a");
  viewer.grab("hand", 3);
  run_for(2 * kTick);
  ASSERT_EQ(grabs("a"), std::vector<std::string>{"hand"});
  for (int i = 0; i < 400; ++i) viewer.drag("hand", 0.001 * i);
  EXPECT_EQ(viewer.failure(), "TOO_MANY_REJECTIONS");
  viewer.session().close();
  run_for(2 * kTick);
  EXPECT_TRUE(grabs("a").empty());
}

TEST_F(WatchTest, GrabUnderWayWhenItsStreamEndsIsReleased) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a");
  host_->wait_idle();
  viewer.grab("late", 3);
  viewer.session().close();  // the command still waits for the tick
  viewer.forget();
  run_for(3 * kTick);
  EXPECT_TRUE(grabs("a").empty());
}

TEST_F(WatchTest, RefusedGrabIsToldAndTakesNothingFromItsOwner) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  Viewer owner(*api_);
  Viewer other(*api_);
  owner.start("sheets/a");
  other.start("sheets/a");
  owner.grab("hand", 3);
  run_for(2 * kTick);
  other.grab("hand", 4);
  other.grab("nowhere", 99999);
  run_for(2 * kTick);
  other.drain();
  ASSERT_EQ(other.others.size(), 2U);
  EXPECT_EQ(other.others[0].rejection().grab_id(), "hand");
  EXPECT_FALSE(other.others[0].rejection().reason().empty());
  EXPECT_EQ(other.others[1].rejection().grab_id(), "nowhere");
  EXPECT_EQ(other.failure(), "");
  other.session().close();
  run_for(2 * kTick);
  EXPECT_EQ(grabs("a"), std::vector<std::string>{"hand"});
}

TEST_F(WatchTest, FloodOfRefusalsEndsTheStream) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a");
  for (int i = 0; i < 300; ++i) viewer.grab("", 0);
  EXPECT_EQ(viewer.failure(), "TOO_MANY_REJECTIONS");
}

}  // namespace
}  // namespace kerf::api
