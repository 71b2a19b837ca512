// Batches, undo and redo, pieces, and a sheet's cuts carried to another.
#include <memory>

#include <gtest/gtest.h>

#include "server/core/mesh/triangle_mesh.h"
#include "server/service/wire/json.h"
#include "tests/api/cuts_fixture.h"
#include "tests/api/viewer.h"

namespace kerf::api {
namespace {

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

}  // namespace
}  // namespace kerf::api
