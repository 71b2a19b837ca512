// Tests the memory of the Api: requests by their id, and the cuts of every sheet.
#include <future>

#include <gtest/gtest.h>

#include "server/service/api/cut_journal.h"
#include "tests/api/fixture.h"

namespace kerf::api {
namespace {

TEST_F(ApiTest, SameRequestIdGetsTheSameAnswerAndDoesNothingMore) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  const v1::CreateCutRequest request = cut_request("sheets/a", 0.45, "once");
  Answers<v1::CutResult> answers;
  api_->create_cut(request, answers.callback());
  api_->create_cut(request, answers.callback());  // while the first is under way
  run_for(2 * kTick);
  api_->create_cut(request, answers.callback());  // after it
  ASSERT_EQ(answers.count(), 3U);
  for (std::size_t i = 1; i < 3; ++i) {
    EXPECT_EQ(answers.at(i)->SerializeAsString(), answers.at(0)->SerializeAsString());
  }
  EXPECT_EQ(get_sheet("sheets/a").topology_version(), 2);

  const Result<v1::CutResult> other = call(&Api::create_cut, cut_request("sheets/a", 0.7, "once"));
  ASSERT_FALSE(other.ok());
  EXPECT_EQ(other.error().code, ErrorCode::kAlreadyExists);
  EXPECT_EQ(other.error().field, "request_id");
  EXPECT_EQ(get_sheet("sheets/a").topology_version(), 2);
}

TEST_F(ApiTest, RefusedRequestMayBeTriedAgainUnderItsId) {
  v1::CreateCutRequest request = cut_request("sheets/late", 0.45, "again");
  EXPECT_EQ(call(&Api::create_cut, request).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(create_sheet("late", true).ok());
  EXPECT_TRUE(call(&Api::create_cut, request).ok());
}

TEST_F(ApiTest, OldestRequestIdsAreForgotten) {
  Limits limits;
  limits.max_remembered_requests = 2;
  make_api(limits, nullptr);
  ASSERT_TRUE(create_sheet("a", true).ok());
  const auto cut = [&](double y, const char* id) {
    return call(&Api::create_cut, cut_request("sheets/a", y, id)).value().topology_version();
  };
  EXPECT_EQ(cut(0.2, "one"), 2);
  EXPECT_EQ(cut(0.4, "two"), 3);
  EXPECT_EQ(cut(0.2, "one"), 2);  // used again: now "two" is the oldest
  EXPECT_EQ(cut(0.6, "three"), 4);
  EXPECT_EQ(cut(0.2, "one"), 2);
  EXPECT_EQ(call(&Api::create_cut, cut_request("sheets/a", 0.4, "two")).value().status(),
            v1::CutResult::NO_INTERSECTION)
      << "done anew: it retraces the earlier cut";
}

TEST_F(ApiTest, CreateSheetIsIdempotentToo) {
  v1::CreateSheetRequest request;
  request.mutable_scene()->mutable_grid()->set_columns(3);
  request.mutable_scene()->mutable_grid()->set_rows(3);
  request.mutable_scene()->mutable_grid()->set_width_m(1.0);
  request.mutable_scene()->mutable_grid()->set_height_m(1.0);
  request.set_request_id("new");
  request.set_paused(true);
  const std::string name = call(&Api::create_sheet, request).value().name();
  EXPECT_EQ(call(&Api::create_sheet, request).value().name(), name);
  EXPECT_EQ(host_->list().size(), 1U);
}

TEST_F(ApiTest, JournalListsTheCutsSinceTheLastReset) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  for (int i = 1; i <= 5; ++i) ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.15 * i)).ok());
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 9.0)).ok());  // misses
  v1::ListCutsRequest list;
  list.set_parent("sheets/a");
  list.set_page_size(2);
  std::vector<double> heights;
  int pages = 0;
  do {
    const v1::ListCutsResponse page = call(&Api::list_cuts, list).value();
    for (const auto& entry : page.cuts()) {
      heights.push_back(entry.cut().curve().polyline().points(0).y());
      EXPECT_EQ(entry.result().name(), "sheets/a/cuts/" + std::to_string(heights.size()));
    }
    list.set_page_token(page.next_page_token());
    ++pages;
  } while (!list.page_token().empty());
  EXPECT_EQ(pages, 3);
  EXPECT_EQ(heights, (std::vector<double>{0.15, 0.3, 0.15 * 3, 0.6, 0.75}));

  v1::ResetSheetRequest reset;
  reset.set_name("sheets/a");
  EXPECT_EQ(call(&Api::reset_sheet, reset).value().pieces(), 1);
  EXPECT_EQ(call(&Api::list_cuts, list).value().cuts_size(), 0);
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.5)).ok());
  EXPECT_EQ(call(&Api::list_cuts, list).value().cuts_size(), 1);

  // The reset can be undone, and redone, and the journal follows.
  list.set_page_size(0);
  v1::UndoCutRequest undo;
  undo.set_parent("sheets/a");
  v1::RedoCutRequest redo;
  redo.set_parent("sheets/a");
  EXPECT_FALSE(call(&Api::undo_cut, undo).value().reset());
  EXPECT_EQ(call(&Api::list_cuts, list).value().cuts_size(), 0);
  EXPECT_TRUE(call(&Api::undo_cut, undo).value().reset());
  EXPECT_EQ(call(&Api::list_cuts, list).value().cuts_size(), 5);
  EXPECT_TRUE(call(&Api::redo_cut, redo).value().reset());
  EXPECT_EQ(call(&Api::list_cuts, list).value().cuts_size(), 0);
  EXPECT_FALSE(call(&Api::redo_cut, redo).value().reset());
  EXPECT_EQ(call(&Api::list_cuts, list).value().cuts_size(), 1);
}

TEST_F(ApiTest, ListedDrawingsCutTheSameAgain) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(create_sheet("b", true).ok());
  v1::CreateCutRequest drawing;
  drawing.set_parent("sheets/a");
  v1::Cut& cut = *drawing.mutable_cut();
  cut.mutable_curve()->mutable_svg()->set_text(
      R"(<svg viewBox="0 0 9 9"><circle cx="4" cy="4" r="3"/><path d="M1 1A5 3 20 0 1 8 8"/><text>no</text></svg>)");
  cut.add_dash(0.3);
  cut.add_dash(0.05);
  const v1::CutResult first = call(&Api::create_cut, drawing).value();
  EXPECT_EQ(first.status(), v1::CutResult::APPLIED);
  ASSERT_EQ(first.warnings_size(), 1);
  EXPECT_EQ(first.warnings(0), "SVG: 1 x text element: not cut");
  v1::ListCutsRequest list;
  list.set_parent("sheets/a");
  const v1::ListCutsResponse listed = call(&Api::list_cuts, list).value();
  ASSERT_EQ(listed.cuts_size(), 1);
  EXPECT_TRUE(listed.cuts(0).cut().curve().has_path());
  v1::CreateCutRequest again;
  again.set_parent("sheets/b");
  *again.mutable_cut() = listed.cuts(0).cut();
  EXPECT_EQ(call(&Api::create_cut, again).value().state_hash(), first.state_hash());
}

TEST_F(ApiTest, APageOfTheJournalFitsInAMessage) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::CreateCutRequest large = cut_request("sheets/a", 0.5);
  auto& points = *large.mutable_cut()->mutable_curve()->mutable_polyline()->mutable_points();
  while (points.size() < 4096) *points.Add() = points[points.size() % 2];
  const std::size_t bytes = large.cut().ByteSizeLong();
  const int num_cuts = static_cast<int>(CutJournal::kMaxPageBytes / bytes) + 2;
  for (int i = 0; i < num_cuts; ++i) {
    for (v1::Vec2& point : points) point.set_y(0.02 + 0.9 * i / num_cuts);
    ASSERT_EQ(call(&Api::create_cut, large).value().status(), v1::CutResult::APPLIED) << i;
  }
  v1::ListCutsRequest list;
  list.set_parent("sheets/a");
  list.set_page_size(1000);
  const v1::ListCutsResponse page = call(&Api::list_cuts, list).value();
  EXPECT_LT(page.ByteSizeLong(), CutJournal::kMaxPageBytes + 1000);
  list.set_page_token(page.next_page_token());
  EXPECT_EQ(page.cuts_size() + call(&Api::list_cuts, list).value().cuts_size(), num_cuts);
}

TEST_F(ApiTest, JournalListsScheduledCutsWithTheOthers) {
  const Result<std::string> created = call_json("/kerf.v1.SheetService/CreateSheet", R"({"sheet_id":"a","paused":true,
      "scene":{"grid":{"columns":7,"rows":7,"width_m":1,"height_m":1},"commands":[
        {"tick":2,"command":{"set_gravity":{"gravity_mps2":{"z":-1}}}},
        {"tick":2,"command":{"cut":{"curve":{"circle":{"center":{"x":0.5,"y":0.5},"radius_m":0.2}}}}},
        {"tick":3,"command":{"cut":{"curve":{"circle":{"center":{"x":9,"y":9},"radius_m":0.2}}}}},
        {"tick":3,"command":{"cut":{"curve":{"circle":{"center":{"x":0.2,"y":0.2},"radius_m":0.1}}}}},
        {"tick":5,"command":{"reset":{}}},
        {"tick":5,"command":{"cut":{"curve":{"circle":{"center":{"x":0.3,"y":0.3},"radius_m":0.1}}}}}]}})");
  ASSERT_TRUE(created.ok()) << created.error().message;
  v1::ListCutsRequest list;
  list.set_parent("sheets/a");
  v1::StepSheetRequest step;
  step.set_name("sheets/a");
  step.set_ticks(3);
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.9)).ok());
  EXPECT_EQ(call(&Api::step_sheet, step).value().topology_version(), 4);
  const v1::ListCutsResponse cuts = call(&Api::list_cuts, list).value();
  ASSERT_EQ(cuts.cuts_size(), 3);
  EXPECT_TRUE(cuts.cuts(0).cut().curve().has_polyline());
  EXPECT_EQ(cuts.cuts(0).result().tick(), 0);
  EXPECT_EQ(cuts.cuts(1).cut().curve().circle().radius_m(), 0.2);
  EXPECT_EQ(cuts.cuts(1).result().tick(), 2);
  EXPECT_EQ(cuts.cuts(1).result().pieces(), 3);
  EXPECT_EQ(cuts.cuts(1).result().name(), "sheets/a/cuts/2");
  EXPECT_EQ(cuts.cuts(1).result().queued_us(), 0.0);
  EXPECT_EQ(cuts.cuts(2).result().tick(), 3);
  EXPECT_EQ(cuts.cuts(2).result().state_hash(), get_sheet("sheets/a").state_hash());

  const host::HostMetrics metrics = host_->metrics();
  EXPECT_EQ(metrics.cuts, 3);
  EXPECT_EQ(metrics.commands, 5) << "the cut by hand and four of the scene";
  EXPECT_EQ(metrics.cut_duration.total, 4U) << "the one that misses, too";

  ASSERT_TRUE(call(&Api::step_sheet, step).ok());
  const v1::ListCutsResponse after_reset = call(&Api::list_cuts, list).value();
  ASSERT_EQ(after_reset.cuts_size(), 1);
  EXPECT_EQ(after_reset.cuts(0).result().tick(), 5);
}

TEST_F(ApiTest, ALateDeletionLeavesTheNextSheetsCutsAlone) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  std::promise<void> release;
  host_->inspect(
      "a", [released = release.get_future().share()](const sheet::Sheet&) { released.wait(); }, [](const Status&) {});
  v1::DeleteSheetRequest remove;
  remove.set_name("sheets/a");
  Answers<google::protobuf::Empty> deleted;
  api_->create_cut(cut_request("sheets/a", 0.3), [](const auto&) {});
  api_->delete_sheet(remove, deleted.callback());
  Answers<std::string> created;  // not call(): it waits until nothing is under way
  for (const Method& method : api_->methods()) {
    if (method.path == "/kerf.v1.SheetService/CreateSheet") {
      method.call(R"({"sheet_id":"a","scene":{"grid":{"columns":3,"rows":3,"width_m":1,"height_m":1}}})",
                  Encoding::kJson, caller_, created.callback(), {});
    }
  }
  ASSERT_EQ(created.count(), 1U);
  EXPECT_EQ(created.reason(0), "SHEET_EXISTS") << "its predecessor's answers are still to come";
  release.set_value();
  host_->wait_idle();
  ASSERT_EQ(deleted.count(), 1U);
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::ListCutsRequest list;
  list.set_parent("sheets/a");
  EXPECT_EQ(call(&Api::list_cuts, list).value().cuts_size(), 0);
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  EXPECT_EQ(call(&Api::list_cuts, list).value().cuts_size(), 1);
}

}  // namespace
}  // namespace kerf::api
