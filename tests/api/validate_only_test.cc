// Cuts that are only tried, by validate_only.
#include <future>
#include <memory>

#include <gtest/gtest.h>

#include "tests/api/cuts_fixture.h"

namespace kerf::api {
namespace {

// Answers of validate_only come from a thread of their own.
template <typename Request, typename Response>
Result<Response> answer_of(Api& api, void (Api::*method)(const Request&, Reply<Response>), const Request& request) {
  auto promise = std::make_shared<std::promise<Result<Response>>>();
  (api.*method)(request, [promise](Result<Response> reply) { promise->set_value(std::move(reply)); });
  return promise->get_future().get();
}

TEST_F(ApiCutsTest, ValidateOnlySaysWhatACutWouldBeAndCutsNothing) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  const std::string before = get_sheet("sheets/a").state_hash();
  v1::CreateCutRequest request = cut_request("sheets/a", 0.59);
  request.mutable_cut()->mutable_curve()->mutable_polyline()->mutable_points(1)->set_y(0.61);
  request.set_validate_only(true);
  const v1::CutResult tried = answer_of(*api_, &Api::create_cut, request).value();
  EXPECT_EQ(tried.name(), "");
  EXPECT_EQ(get_sheet("sheets/a").state_hash(), before);
  EXPECT_TRUE(names().empty());
  request.set_validate_only(false);
  const v1::CutResult done = call(&Api::create_cut, request).value();
  EXPECT_EQ(tried.status(), done.status());
  EXPECT_EQ(tried.pieces(), done.pieces());
  EXPECT_EQ(tried.state_hash(), done.state_hash());
  EXPECT_EQ(tried.new_vertices(), done.new_vertices());
  EXPECT_EQ(tried.tick_before_us(), done.tick_before_us());
  EXPECT_EQ(tried.tick_after_us(), done.tick_after_us());
  EXPECT_GT(done.tick_after_us(), done.tick_before_us());
  EXPECT_EQ(done.tick_after_us(), get_sheet("sheets/a").tick_estimate().total_us());
  EXPECT_EQ(done.tick_budget_us(), get_sheet("sheets/a").tick_estimate().budget_us());
}

TEST_F(ApiCutsTest, ValidateOnlyOfABatchIsOfAllItsCutsTogether) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::CreateCutsRequest request = batch_request("sheets/a", {0.3, 7.0, 0.6});
  request.set_validate_only(true);
  const v1::CreateCutsResponse tried = answer_of(*api_, &Api::create_cuts, request).value();
  EXPECT_EQ(tried.applied(), 2);
  EXPECT_EQ(tried.pieces(), 3);
  EXPECT_EQ(tried.tick_budget_us(), get_sheet("sheets/a").tick_estimate().budget_us());
  for (const v1::CutResult& result : tried.results()) EXPECT_EQ(result.name(), "");
  EXPECT_TRUE(names().empty());
  EXPECT_EQ(get_sheet("sheets/a").pieces(), 1);
}

TEST_F(ApiCutsTest, ValidateOnlyRefusesWhatACutWould) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::CreateCutRequest fine = cut_request("sheets/a", 0.45);
  fine.mutable_cut()->set_max_new_triangles(1);
  fine.set_validate_only(true);
  const Result<v1::CutResult> refused = answer_of(*api_, &Api::create_cut, fine);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(refused.error().field, "cut");
  v1::CreateCutRequest later = cut_request("sheets/a", 0.5);
  later.set_validate_only(true);
  later.set_at_tick(5);
  EXPECT_EQ(call(&Api::create_cut, later).error().field, "at_tick");
  v1::CreateCutRequest nowhere = cut_request("sheets/none", 0.5);
  nowhere.set_validate_only(true);
  EXPECT_EQ(call(&Api::create_cut, nowhere).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace kerf::api
