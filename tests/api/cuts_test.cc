// Batches, undo and redo, cuts with a tick of their own, pieces, and a sheet's cuts carried to another.
#include <future>
#include <memory>

#include <gtest/gtest.h>

#include "server/core/mesh/triangle_mesh.h"
#include "server/service/api/tick_advice.h"
#include "server/service/wire/json.h"
#include "tests/api/fixture.h"
#include "tests/api/viewer.h"

namespace kerf::api {
namespace {

class ApiCutsTest : public ApiTest {
 protected:
  static v1::CreateCutsRequest batch_request(const std::string& parent, const std::vector<double>& heights) {
    v1::CreateCutsRequest request;
    request.set_parent(parent);
    for (const double y : heights) *request.add_cuts() = cut_request(parent, y).cut();
    return request;
  }
  Result<v1::UndoResult> undo(const std::string& request_id = {}) {
    v1::UndoCutRequest request;
    request.set_parent("sheets/a");
    request.set_request_id(request_id);
    return call(&Api::undo_cut, request);
  }
  Result<v1::UndoResult> redo() {
    v1::RedoCutRequest request;
    request.set_parent("sheets/a");
    return call(&Api::redo_cut, request);
  }
  v1::ListCutsResponse list(const std::string& parent = "sheets/a") {
    v1::ListCutsRequest request;
    request.set_parent(parent);
    return call(&Api::list_cuts, request).value();
  }
  std::vector<std::string> names() {
    std::vector<std::string> found;
    const v1::ListCutsResponse all = list();
    for (const auto& entry : all.cuts()) found.push_back(entry.result().name());
    return found;
  }
  Result<v1::Sheet> step(std::int32_t ticks) {
    v1::StepSheetRequest request;
    request.set_name("sheets/a");
    request.set_ticks(ticks);
    return call(&Api::step_sheet, request);
  }
};

TEST_F(ApiCutsTest, ASheetTellsOfTheClustersThatCutsMake) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(call(&Api::create_cuts, batch_request("sheets/a", {0.6})).ok());
  EXPECT_FALSE(get_sheet("sheets/a").has_local_inertia());
  v1::CreateCutRequest oblique = cut_request("sheets/a", 0.59);
  oblique.mutable_cut()->mutable_curve()->mutable_polyline()->mutable_points(1)->set_y(0.61);
  ASSERT_TRUE(call(&Api::create_cut, oblique).ok());
  const v1::Sheet sheet = get_sheet("sheets/a");
  ASSERT_TRUE(sheet.has_local_inertia());
  const v1::LocalInertia& inertia = sheet.local_inertia();
  EXPECT_GE(inertia.clusters(), 1);
  EXPECT_GE(inertia.vertices(), inertia.largest_cluster_vertices());
  EXPECT_GE(inertia.largest_cluster_vertices(), 2);
  EXPECT_GT(inertia.plain_substeps(), inertia.planned_substeps());
  EXPECT_GE(inertia.planned_substeps(), 1.0);
}

TEST_F(ApiCutsTest, ABatchIsOneVersionAndTellsOfEachCut) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  const Result<v1::CreateCutsResponse> done = call(&Api::create_cuts, batch_request("sheets/a", {0.3, 7.0, 0.6}));
  ASSERT_TRUE(done.ok()) << done.error().message;
  EXPECT_EQ(done->status(), v1::CutResult::APPLIED);
  EXPECT_EQ(done->applied(), 2);
  EXPECT_EQ(done->topology_version(), 2);
  EXPECT_EQ(done->pieces(), 3);
  ASSERT_EQ(done->results_size(), 3);
  EXPECT_EQ(done->results(0).name(), "sheets/a/cuts/1");
  EXPECT_EQ(done->results(1).status(), v1::CutResult::NO_INTERSECTION);
  EXPECT_EQ(done->results(2).name(), "sheets/a/cuts/2");
  EXPECT_EQ(done->new_vertices(), done->results(0).new_vertices() + done->results(2).new_vertices());
  EXPECT_EQ(done->state_hash(), get_sheet("sheets/a").state_hash());
  EXPECT_EQ(names(), (std::vector<std::string>{"sheets/a/cuts/1", "sheets/a/cuts/2"}));
  EXPECT_EQ(call(&Api::create_cuts, batch_request("sheets/a", {8.0, 7.0}))->status(), v1::CutResult::NO_INTERSECTION);
}

TEST_F(ApiCutsTest, ABatchThatIsRefusedChangesNothingAndNamesTheCut) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  const std::string before = get_sheet("sheets/a").state_hash();
  v1::CreateCutsRequest request = batch_request("sheets/a", {0.3, 0.6, 0.8});
  request.mutable_cuts(1)->set_max_new_triangles(1);
  const Result<v1::CreateCutsResponse> refused = call(&Api::create_cuts, request);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(refused.error().field, "cuts[1]");
  EXPECT_EQ(get_sheet("sheets/a").state_hash(), before);
  EXPECT_TRUE(names().empty());
}

TEST_F(ApiCutsTest, UndoAndRedoTakeCutsOffTheListAndPutThemBack) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.2)).ok());
  ASSERT_TRUE(call(&Api::create_cuts, batch_request("sheets/a", {0.4, 0.6})).ok());
  const std::vector<std::string> all = names();
  ASSERT_EQ(all.size(), 3U);

  const Result<v1::UndoResult> undone = undo("once");
  ASSERT_TRUE(undone.ok()) << undone.error().message;
  ASSERT_EQ(undone->cuts_size(), 2);
  EXPECT_EQ(undone->cuts(0), all[1]);
  EXPECT_EQ(undone->cuts(1), all[2]);
  EXPECT_EQ(undone->pieces(), 2);
  EXPECT_EQ(undone->topology_version(), 4);
  EXPECT_EQ(undone->tick_budget_us(), get_sheet("sheets/a").tick_estimate().budget_us());
  EXPECT_EQ(undone->undo_steps(), 1);
  EXPECT_EQ(undone->redo_steps(), 1);
  EXPECT_EQ(undo("once")->SerializeAsString(), undone->SerializeAsString()) << "a repeat undoes nothing more";
  EXPECT_EQ(names(), std::vector<std::string>{all[0]});

  ASSERT_TRUE(step(3).ok());
  const Result<v1::UndoResult> redone = redo();
  ASSERT_TRUE(redone.ok());
  EXPECT_EQ(redone->pieces(), 4);
  EXPECT_EQ(names(), all) << "under the names that they had";
  EXPECT_EQ(list().cuts(2).result().topology_version(), 5);
  EXPECT_EQ(list().cuts(2).result().tick(), 3);
  EXPECT_EQ(redo().error().reason, "NOTHING_TO_REDO");

  ASSERT_TRUE(undo().ok());
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.9)).ok());
  EXPECT_EQ(names(), (std::vector<std::string>{all[0], "sheets/a/cuts/4"}));
  ASSERT_TRUE(undo().ok());
  ASSERT_TRUE(undo().ok());
  EXPECT_TRUE(names().empty());
  EXPECT_EQ(undo().error().reason, "NOTHING_TO_UNDO");
}

TEST_F(ApiCutsTest, WhatOneTickDoesIsListedInItsOrder) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  const std::int64_t next = get_sheet("sheets/a").tick() + 1;
  v1::CreateCutRequest scheduled = cut_request("sheets/a", 0.2);
  scheduled.set_at_tick(next);
  Answers<v1::CutResult> cuts;
  Answers<v1::UndoResult> undone;
  v1::UndoCutRequest undo;
  undo.set_parent("sheets/a");
  api_->create_cut(scheduled, cuts.callback());
  host_->wait_idle();
  api_->create_cut(cut_request("sheets/a", 0.45), cuts.callback());
  api_->undo_cut(undo, undone.callback());
  api_->create_cut(cut_request("sheets/a", 0.7), cuts.callback());
  run_for(kTick);
  ASSERT_EQ(cuts.count(), 3U);
  ASSERT_EQ(undone.count(), 1U);
  EXPECT_EQ(cuts.at(2)->tick(), next);
  EXPECT_EQ(undone.at(0)->cuts(0), cuts.at(1)->name());
  const v1::ListCutsResponse listed = list();
  ASSERT_EQ(listed.cuts_size(), 2);
  EXPECT_FALSE(listed.cuts(0).result().scheduled_name().empty());
  EXPECT_EQ(listed.cuts(1).result().DebugString(), cuts.at(2)->DebugString());
}

TEST_F(ApiCutsTest, ViewersFollowUndoAndRedo) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a");
  const auto same = [&] {
    run_for(2 * kTick);
    viewer.drain();
    ASSERT_EQ(viewer.failure(), "");
    host_->inspect(
        "a",
        [&](const sheet::Sheet& sheet) {
          const std::shared_ptr<const sheet::Topology> topology = sheet.snapshot()->topology;
          EXPECT_EQ(viewer.mirror.topology_version, topology->version);
          EXPECT_EQ(viewer.mirror.triangles, topology->triangles);
          EXPECT_EQ(viewer.mirror.pieces, topology->pieces);
          EXPECT_EQ(viewer.mirror.num_pieces, topology->num_pieces);
          EXPECT_EQ(viewer.mirror.material.size(), topology->vertex_versions.size());
          EXPECT_EQ(viewer.mirror.quantised.size(), 3 * topology->vertex_versions.size());
        },
        [](const Status&) {});
    host_->wait_idle();
  };
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  same();
  ASSERT_TRUE(undo().ok());
  same();
  ASSERT_TRUE(redo().ok());
  same();
}

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

TEST_F(ApiCutsTest, PiecesAreListedWithTheirParents) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  const Result<v1::CutResult> cut = call(&Api::create_cut, cut_request("sheets/a", 0.25));
  ASSERT_TRUE(cut.ok());
  ASSERT_EQ(cut->split_pieces_size(), 1);
  EXPECT_EQ(cut->split_pieces(0).piece(), 1);
  ASSERT_EQ(cut->split_pieces(0).children_size(), 2);
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.5)).ok());

  v1::ListPiecesRequest request;
  request.set_parent("sheets/a");
  request.set_page_size(2);
  std::vector<v1::Piece> pieces;
  do {
    const v1::ListPiecesResponse page = call(&Api::list_pieces, request).value();
    EXPECT_EQ(page.topology_version(), 3);
    for (const v1::Piece& piece : page.pieces()) pieces.push_back(piece);
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  ASSERT_EQ(pieces.size(), 3U);
  double area = 0.0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    area += pieces[i].area_m2();
    EXPECT_GT(pieces[i].id(), i == 0 ? 0 : pieces[i - 1].id());
    EXPECT_GT(pieces[i].mass_kg(), 0.0);
    EXPECT_NEAR(pieces[i].world_centroid().z(), pieces[i].centroid().y(), 1e-9) << "it hangs upright";
  }
  EXPECT_NEAR(area, 1.0, 1e-12);
  EXPECT_EQ(pieces[2].cut_number(), 2);
}

TEST_F(ApiCutsTest, CutsOfOneSheetMakeTheSameMeshOfAnother) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(create_sheet("b", true).ok());
  for (const double y : {0.21, 0.43, 0.64}) ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", y)).ok());
  ASSERT_TRUE(undo().ok());
  v1::CreateCutsRequest request;
  request.set_parent("sheets/b");
  const v1::ListCutsResponse exported = list();
  for (const auto& entry : exported.cuts()) *request.add_cuts() = entry.cut();
  EXPECT_EQ(request.cuts_size(), 2);
  v1::CreateCutsRequest read;  // as from a file
  ASSERT_TRUE(wire::from_json(wire::to_json(request), read).ok());
  ASSERT_TRUE(call(&Api::create_cuts, read).ok());
  std::uint64_t mesh_of_a = 0;
  std::uint64_t mesh_of_b = 0;
  host_->inspect(
      "a", [&](const sheet::Sheet& sheet) { mesh_of_a = sheet.mesh().state_hash(); }, [](const auto&) {});
  host_->inspect(
      "b", [&](const sheet::Sheet& sheet) { mesh_of_b = sheet.mesh().state_hash(); }, [](const auto&) {});
  host_->wait_idle();
  EXPECT_EQ(mesh_of_a, mesh_of_b);
  EXPECT_NE(mesh_of_a, 0U);
}

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

TEST_F(ApiCutsTest, ASheetWhoseTicksDoNotFitSaysWhyAndWhatHelps) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  const v1::TickEstimate fits = get_sheet("sheets/a").tick_estimate();
  double sum = 0.0;
  for (const auto& [part, us] : fits.parts_us()) sum += us;
  EXPECT_NEAR(sum, fits.total_us(), 1e-9 * sum);
  EXPECT_EQ(fits.total_us(), fits.counted_us()) << "no tick was timed";
  EXPECT_EQ(fits.budget_us(), 20'000.0);
  EXPECT_EQ(fits.advice(), "");

  v1::CreateSheetRequest request;
  request.set_sheet_id("stiff");
  request.set_paused(true);
  v1::GridMesh& grid = *request.mutable_scene()->mutable_grid();
  grid.set_columns(40);
  grid.set_rows(40);
  grid.set_width_m(1.0);
  grid.set_height_m(1.0);
  request.mutable_scene()->mutable_material()->set_preset("wool");
  request.mutable_scene()->mutable_integrator()->set_kind(v1::Integrator::EXPLICIT_LEAPFROG);
  request.mutable_scene()->mutable_wind()->mutable_velocity_mps()->set_x(1.0);
  const v1::TickEstimate slow = call(&Api::create_sheet, request).value().tick_estimate();
  EXPECT_GT(slow.total_us(), slow.budget_us());
  EXPECT_NE(slow.advice().find("wind and other loads"), std::string::npos) << slow.advice();
  EXPECT_NE(slow.advice().find("Remedy: no wind"), std::string::npos) << slow.advice();
  EXPECT_NE(slow.advice().find("substeps"), std::string::npos) << slow.advice();
}

TEST_F(ApiCutsTest, ACutThatEndsRealTimeIsWarnedOf) {
  host::CommandTimings timings;
  timings.tick_before_us = 5'000.0;
  timings.tick_after_us = 40'000.0;
  timings.budget_us = 20'000.0;
  EXPECT_EQ(warning_of_slower_ticks(timings),
            "The sheet now falls behind: a tick takes 40 ms of the 20 ms available; before the cut it took 5 ms.");
  timings.tick_after_us = 20'000.0;
  EXPECT_EQ(warning_of_slower_ticks(timings), "");
  timings.tick_before_us = 30'000.0;
  timings.tick_after_us = 40'000.0;
  EXPECT_EQ(warning_of_slower_ticks(timings), "") << "it was behind before";
}

}  // namespace
}  // namespace kerf::api
