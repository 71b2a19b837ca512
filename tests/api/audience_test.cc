// Who watches a sheet, what callers did to it, and where viewers point.

#include "server/service/api/audience.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/api/fixture.h"
#include "tests/api/viewer.h"

namespace kerf::api {
namespace {

using ::testing::ElementsAre;

auth::Caller named(const std::string& id, auth::Scope scope = auth::Scope::kCut) {
  return {std::make_shared<const auth::Grant>(id, auth::Rights{scope, "*", 0}, [] { return std::int64_t{5}; }), {}};
}

v1::Pointer pointer_at(double x) {
  v1::Pointer pointer;
  pointer.mutable_material()->set_x(x);
  return pointer;
}

class AudienceTest : public ::testing::Test {
 protected:
  std::shared_ptr<Audience::Seat> join(const std::string& sheet, const std::string& id, int* woken = nullptr) {
    return audience_->join(sheet, named(id), false, [woken] {
      if (woken != nullptr) ++*woken;
    });
  }
  // Returns all messages that wait, each in one line.
  static std::vector<std::string> news(Audience::Seat& seat) {
    std::vector<std::string> lines;
    while (const std::optional<v1::WatchResponse> message = seat.next()) {
      if (message->has_audience()) {
        std::string line = std::to_string(message->audience().num_viewers()) + ":";
        for (const v1::Viewer& viewer : message->audience().viewers()) {
          line += " " + viewer.token_id() + (viewer.number() == message->audience().own_number() ? "*" : "");
        }
        lines.push_back(line);
      } else if (message->has_activity()) {
        lines.push_back(message->activity().token_id() + " " + message->activity().call());
      } else {
        const v1::Pointer& pointer = message->pointer();
        lines.push_back(std::to_string(pointer.viewer()) + " at " +
                        (pointer.has_material() ? std::to_string(std::lround(pointer.material().x())) : "nothing"));
      }
    }
    return lines;
  }

  // Lets a turn begin, if one is planned.
  void turn() { clock_.move_to(clock_.now() + Audience::kTurn); }

  test::ManualClock clock_;
  const std::shared_ptr<Audience> audience_ = std::make_shared<Audience>(clock_);
};

TEST_F(AudienceTest, ListsThoseWhoWatchTheSheet) {
  int woken = 0;
  const auto alice = join("a", "alice", &woken);
  EXPECT_THAT(news(*alice), ElementsAre("1: alice*"));
  auto bob = join("a", "bob");
  const auto other = join("b", "carol");
  EXPECT_THAT(news(*bob), ElementsAre("2: alice bob*")) << "at once";
  EXPECT_THAT(news(*other), ElementsAre("1: carol*"));
  turn();
  EXPECT_EQ(woken, 2) << "as it joined, and for bob";
  EXPECT_THAT(news(*alice), ElementsAre("2: alice* bob"));
  bob.reset();
  turn();
  EXPECT_EQ(woken, 3);
  EXPECT_THAT(news(*alice), ElementsAre("1: alice*"));
  EXPECT_THAT(news(*alice), ElementsAre());
}

TEST_F(AudienceTest, ChangesWithinATurnComeTogether) {
  int woken = 0;
  const auto alice = join("a", "alice", &woken);
  news(*alice);
  for (int i = 0; i < 100; ++i) {
    join("a", "bob");
    EXPECT_THAT(news(*alice), ElementsAre());
  }
  EXPECT_EQ(woken, 1);
  turn();
  EXPECT_EQ(woken, 2);
  EXPECT_THAT(news(*alice), ElementsAre("1: alice*"));
  turn();
  EXPECT_EQ(woken, 2) << "nothing is new";
  std::vector<std::shared_ptr<Audience::Seat>> many;
  for (int i = 0; i < 80; ++i) many.push_back(audience_->join("a", named("x"), true, nullptr));
  turn();
  const v1::Audience list = alice->next()->audience();
  EXPECT_EQ(list.num_viewers(), 81);
  EXPECT_EQ(list.viewers_size(), 64);
  EXPECT_TRUE(list.viewers(1).pictures());
}

TEST_F(AudienceTest, KeepsTheLastChangesForThoseWhoJoinLater) {
  for (int i = 0; i < 40; ++i) audience_->add("a", named("alice"), "Call" + std::to_string(i));
  const auto bob = join("a", "bob");
  std::vector<std::string> first = news(*bob);
  ASSERT_EQ(first.size(), 33u);
  EXPECT_EQ(first[1], "alice Call8");
  EXPECT_EQ(first.back(), "alice Call39");
  turn();
  audience_->add("a", named("bob"), "Undo");
  EXPECT_THAT(news(*bob), ElementsAre("bob Undo")) << "without delay after a quiet time";
  for (int i = 0; i < 40; ++i) audience_->add("a", named("alice"), "Late" + std::to_string(i));
  turn();
  EXPECT_EQ(news(*bob).size(), 32u) << "what a late reader missed is gone";
  audience_->forget("a");
  EXPECT_THAT(news(*join("a", "carol")), ElementsAre("2: bob carol*"));
}

TEST_F(AudienceTest, ShowsWhereTheOthersPoint) {
  const auto alice = join("a", "alice"), bob = join("a", "bob");
  turn();
  turn();
  news(*alice);
  news(*bob);
  for (int i = 0; i <= 1000; ++i) alice->point(pointer_at(i));
  EXPECT_THAT(news(*bob), ElementsAre("1 at 1000")) << "the newest alone";
  turn();
  EXPECT_THAT(news(*alice), ElementsAre()) << "not one's own";
  EXPECT_THAT(news(*bob), ElementsAre());
  alice->point({});
  alice->point({});
  turn();
  EXPECT_THAT(news(*bob), ElementsAre("1 at nothing"));
}

TEST_F(AudienceTest, EightPointAtATime) {
  std::vector<std::shared_ptr<Audience::Seat>> all;
  for (int i = 0; i < 10; ++i) all.push_back(join("a", "x"));
  turn();
  for (const auto& each : all) news(*each);
  for (int i = 0; i < 10; ++i) all[static_cast<std::size_t>(i)]->point(pointer_at(i));
  turn();
  EXPECT_THAT(news(*all[9]),
              ElementsAre("1 at 0", "2 at 1", "3 at 2", "4 at 3", "5 at 4", "6 at 5", "7 at 6", "8 at 7"));
  all[0]->point({});
  all[8]->point(pointer_at(8.0));
  turn();
  EXPECT_THAT(news(*all[9]), ElementsAre("1 at nothing", "9 at 8"));
}

class WatchAudienceTest : public ApiTest {
 protected:
  void start(Viewer& viewer, bool audience) {
    v1::WatchRequest request;
    request.mutable_start()->set_name("sheets/a");
    request.mutable_start()->set_audience(audience);
    viewer.session().on_request(request);
    settle();
    viewer.drain();
  }
  // Lets what has changed reach the streams.
  void settle() {
    host_->wait_idle();
    run_for(2 * Audience::kTurn);
  }
};

TEST_F(WatchAudienceTest, AStreamHasItOnlyIfItAsks) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/ResetSheet", R"({"name":"sheets/a"})").ok());
  Viewer asks(*api_), other(*api_);
  start(asks, true);
  ASSERT_EQ(asks.others.size(), 2u);
  EXPECT_EQ(asks.others[0].audience().num_viewers(), 1);
  EXPECT_EQ(asks.others[1].activity().call(), "ResetSheet");
  start(other, false);
  EXPECT_TRUE(other.others.empty());
  settle();
  asks.drain();
  ASSERT_EQ(asks.others.size(), 3u);
  EXPECT_EQ(asks.others[2].audience().num_viewers(), 2);
  other.session().close();
  settle();
  asks.drain();
  EXPECT_EQ(asks.others.back().audience().num_viewers(), 1);
}

TEST_F(WatchAudienceTest, NothingIsKeptOfSheetsThatAreGone) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/ResetSheet", R"({"name":"sheets/a"})").ok());
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/DeleteSheet", R"({"name":"sheets/a"})").ok());
  ASSERT_TRUE(create_sheet("a", true).ok());
  Viewer viewer(*api_);
  start(viewer, true);
  EXPECT_EQ(viewer.others.size(), 1u) << "the audience alone";
}

TEST_F(WatchAudienceTest, HandsAndCallsOfOthersAreShown) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  Viewer viewer(*api_), hand(*api_);
  start(viewer, true);
  start(hand, true);
  viewer.drain();
  viewer.others.clear();
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/ResetSheet", R"({"name":"sheets/a"})").ok());
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/GetSheet", R"({"name":"sheets/a"})").ok());
  ASSERT_FALSE(call_json("/kerf.v1.CutService/UndoCut", R"({"parent":"sheets/b"})").ok());
  hand.grab("hand", 3);
  settle();
  v1::WatchRequest point;
  *point.mutable_pointer() = pointer_at(0.5);
  hand.session().on_request(point);
  settle();
  viewer.drain();
  ASSERT_EQ(viewer.others.size(), 3u);
  EXPECT_EQ(viewer.others[0].activity().call(), "ResetSheet");
  EXPECT_EQ(viewer.others[1].activity().call(), "GrabPoint");
  EXPECT_EQ(viewer.others[2].pointer().material().x(), 0.5);
  point.mutable_pointer()->mutable_material()->set_x(std::numeric_limits<double>::quiet_NaN());
  hand.session().on_request(point);
  EXPECT_EQ(hand.session().failure()->reason, "NOT_FINITE");
}

}  // namespace
}  // namespace kerf::api
