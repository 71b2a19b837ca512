// Cuts with a tick of their own: done, taken back, refused, and limited in number.
#include <gtest/gtest.h>

#include "tests/api/cuts_fixture.h"

namespace kerf::api {
namespace {

TEST_F(ApiCutsTest, ACutWithATickIsDoneAtTheStartOfIt) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(step(2).ok());
  v1::CreateCutRequest request = cut_request("sheets/a", 0.45);
  request.set_at_tick(2);
  const Result<v1::CutResult> past = call(&Api::create_cut, request);
  ASSERT_FALSE(past.ok());
  EXPECT_EQ(past.error().code, ErrorCode::kFailedPrecondition);
  EXPECT_EQ(past.error().reason, "TICK_PAST");
  EXPECT_EQ(past.error().field, "at_tick");

  request.set_at_tick(5);
  const Result<v1::CutResult> accepted = call(&Api::create_cut, request);
  ASSERT_TRUE(accepted.ok()) << accepted.error().message;
  EXPECT_EQ(accepted->status(), v1::CutResult::SCHEDULED);
  EXPECT_EQ(accepted->tick(), 5);
  EXPECT_EQ(accepted->scheduled_name(), "sheets/a/scheduledCuts/1");
  v1::CreateCutsRequest batch = batch_request("sheets/a", {0.2, 0.7});
  batch.set_at_tick(4);
  EXPECT_EQ(call(&Api::create_cuts, batch)->status(), v1::CutResult::SCHEDULED);
  v1::ListCutsResponse waiting = list();
  EXPECT_EQ(waiting.cuts_size(), 0);
  ASSERT_EQ(waiting.scheduled_size(), 2);
  EXPECT_EQ(waiting.scheduled(0).state(), v1::ScheduledCuts::WAITING);
  EXPECT_EQ(waiting.scheduled(0).tick(), 4);
  EXPECT_EQ(waiting.scheduled(0).cuts_size(), 2);
  EXPECT_EQ(waiting.scheduled(1).tick(), 5);
  EXPECT_EQ(waiting.scheduled(0).name(), "sheets/a/scheduledCuts/2");

  EXPECT_EQ(step(1)->pieces(), 1);
  EXPECT_EQ(step(1)->pieces(), 3);
  EXPECT_EQ(step(1)->pieces(), 4);
  EXPECT_EQ(list().scheduled_size(), 0);
  ASSERT_EQ(list().cuts_size(), 3);
  EXPECT_EQ(list().cuts(0).result().tick(), 4);
  EXPECT_EQ(list().cuts(2).result().tick(), 5);
  EXPECT_EQ(list().cuts(0).result().scheduled_name(), "sheets/a/scheduledCuts/2");
  EXPECT_EQ(list().cuts(2).result().scheduled_name(), "sheets/a/scheduledCuts/1");
}

TEST_F(ApiCutsTest, AScheduledCutIsTakenBack) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::CreateCutRequest request = cut_request("sheets/a", 0.45);
  request.set_at_tick(2);
  v1::CancelScheduledCutsRequest cancel;
  cancel.set_name(call(&Api::create_cut, request)->scheduled_name());
  v1::CreateCutsRequest batch = batch_request("sheets/a", {0.2, 0.7});
  batch.set_at_tick(2);
  const std::string kept = call(&Api::create_cuts, batch)->scheduled_name();
  EXPECT_EQ(kept, "sheets/a/scheduledCuts/2");
  cancel.set_request_id("once");
  const Result<v1::ScheduledCuts> cancelled = call(&Api::cancel_scheduled_cuts, cancel);
  ASSERT_TRUE(cancelled.ok()) << cancelled.error().message;
  EXPECT_EQ(cancelled->state(), v1::ScheduledCuts::CANCELLED);
  EXPECT_EQ(cancelled->name(), cancel.name());
  EXPECT_EQ(cancelled->tick(), 2);
  ASSERT_EQ(cancelled->cuts_size(), 1);
  EXPECT_EQ(call(&Api::cancel_scheduled_cuts, cancel)->state(), v1::ScheduledCuts::CANCELLED);  // the same request
  const auto refusal = [&](const std::string& name) {
    cancel.set_name(name);
    cancel.clear_request_id();
    const Result<v1::ScheduledCuts> refused = call(&Api::cancel_scheduled_cuts, cancel);
    EXPECT_EQ(refused.error().field, refused.error().code == ErrorCode::kFailedPrecondition ? "" : "name");
    return refused.error().reason;
  };
  EXPECT_EQ(refusal(cancel.name()), "SCHEDULED_CUTS_SETTLED");
  ASSERT_EQ(list().scheduled_size(), 1);
  EXPECT_EQ(step(2)->pieces(), 3);  // those of the batch
  EXPECT_EQ(refusal(kept), "SCHEDULED_CUTS_SETTLED");
  EXPECT_EQ(refusal("sheets/a/scheduledCuts/3"), "SCHEDULED_CUTS_NOT_FOUND");
  EXPECT_EQ(refusal("sheets/nobody/scheduledCuts/1"), "SHEET_NOT_FOUND");
  for (const char* name : {"", "sheets/a", "sheets/a/cuts/1", "sheets/a/scheduledCuts/", "sheets/a/scheduledCuts/0",
                           "sheets/a/scheduledCuts/-1", "sheets/a/scheduledCuts/1x", "sheets/A/scheduledCuts/1",
                           "/scheduledCuts/1", "sheets/a/scheduledCuts/99999999999999999999"}) {
    EXPECT_EQ(refusal(name), "NAME_MALFORMED") << name;
  }
}

TEST_F(ApiCutsTest, ARefusedScheduledCutIsTold) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::CreateCutRequest request = cut_request("sheets/a", 0.45);
  request.mutable_cut()->set_max_new_triangles(1);
  request.set_at_tick(1);
  ASSERT_TRUE(call(&Api::create_cut, request).ok());
  ASSERT_TRUE(step(1).ok());
  const v1::ListCutsResponse after = list();
  EXPECT_EQ(after.cuts_size(), 0);
  ASSERT_EQ(after.scheduled_size(), 1);
  EXPECT_EQ(after.scheduled(0).state(), v1::ScheduledCuts::REFUSED);
  EXPECT_EQ(after.scheduled(0).reason(), "CUT_ELEMENT_BUDGET");
  EXPECT_EQ(after.scheduled(0).tick(), 1);
  EXPECT_FALSE(after.scheduled(0).message().empty());
  EXPECT_EQ(after.scheduled(0).cuts(0).max_new_triangles(), 1);

  v1::ResetSheetRequest reset;
  reset.set_name("sheets/a");
  ASSERT_TRUE(call(&Api::reset_sheet, reset).ok());
  EXPECT_EQ(list().scheduled_size(), 0);
}

TEST_F(ApiCutsTest, AsManyCutsWaitForTheirTickAsTheLimitSays) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::CreateCutRequest request = cut_request("sheets/a", 0.45);
  request.set_at_tick(100);
  const std::int32_t limit = host_->options().max_scheduled_commands;
  for (std::int32_t i = 0; i < limit; ++i) ASSERT_TRUE(call(&Api::create_cut, request).ok()) << i;
  const Result<v1::CutResult> beyond = call(&Api::create_cut, request);
  ASSERT_FALSE(beyond.ok());
  EXPECT_EQ(beyond.error().reason, "TOO_MANY_SCHEDULED");
  EXPECT_EQ(list().scheduled_size(), limit);
}

}  // namespace
}  // namespace kerf::api
