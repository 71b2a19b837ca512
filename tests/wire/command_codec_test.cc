// Commands, and the replies to them.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "kerf/v1/cuts.pb.h"
#include "kerf/v1/run.pb.h"
#include "server/service/wire/command_codec.h"
#include "server/service/wire/reply_codec.h"
#include "tests/wire/codec_checks.h"
#include "tests/wire/scene_samples.h"

namespace kerf::wire {
namespace {

using testing::full_scene;

TEST(CommandCodec, EveryKindComesBackUnchanged) {
  const v1::Scene scene = full_scene();
  ASSERT_EQ(scene.commands_size(), 21);
  for (const v1::ScheduledCommand& scheduled : scene.commands()) {
    const Result<scene::Command> command = decode_command(scheduled.command());
    ASSERT_TRUE(command.ok()) << command.error().message;
    expect_equal(encode_command(*command), scheduled.command());
  }
}

TEST(CommandCodec, ZerosOfACutMeanTheDefaults) {
  v1::Cut cut;
  cut.mutable_curve()->mutable_circle()->set_radius_m(0.1);
  const Result<scene::Command> command = decode_cut(cut);
  ASSERT_TRUE(command.ok());
  EXPECT_EQ(std::get<scene::Cut>(*command).options.tolerance, 0.02);
  EXPECT_EQ(std::get<scene::Cut>(*command).options.min_angle_deg, 20.0);
  EXPECT_EQ(std::get<scene::Cut>(*command).options.max_new_triangles, 200'000);
  EXPECT_EQ(std::get<scene::Cut>(*command).options.method, cut::Method::kNeighbourhood);
  EXPECT_FALSE(std::get<scene::Cut>(*command).options.tip_edge_length_m.has_value());
  EXPECT_EQ(std::get<scene::Cut>(*command).options.tip_grading, 1.5);
  EXPECT_FALSE(std::get<scene::Cut>(*command).options.tolerance_m.has_value());
  EXPECT_TRUE(std::get<scene::Cut>(*command).options.relax);
  EXPECT_FALSE(std::get<scene::Cut>(*command).options.width_m.has_value());
}

TEST(CommandCodec, WhatABatchUnfoldsToIsLimited) {
  constexpr int kSegments = 9000;
  std::string drawing = "<svg viewBox=\"0 0 9 9\"><path d=\"M 0 0";
  for (int i = 0; i < kSegments; ++i) drawing += i % 2 == 0 ? " h 1" : " v 1";
  v1::Cut cut;
  cut.mutable_curve()->mutable_svg()->set_text(drawing + "\"/></svg>");
  google::protobuf::RepeatedPtrField<v1::Cut> cuts;
  while ((cuts.size() + 1) * (kSegments + 2) <= kMaxBatchParts) *cuts.Add() = cut;
  EXPECT_TRUE(decode_cuts(cuts).ok());
  *cuts.Add() = cut;
  const Result<scene::Command> more = decode_cuts(cuts);
  ASSERT_FALSE(more.ok());
  EXPECT_EQ(more.error().reason, "BATCH_TOO_LONG");
  EXPECT_EQ(more.error().field, "cut_batch.cuts[14].curve");
}

TEST(CommandCodec, FineQualityIsAnAngle) {
  v1::Cut cut;
  cut.mutable_curve()->mutable_circle()->set_radius_m(0.1);
  cut.set_quality(v1::Cut::FINE);
  const Result<scene::Command> command = decode_cut(cut);
  ASSERT_TRUE(command.ok());
  EXPECT_EQ(std::get<scene::Cut>(*command).options.min_angle_deg, 25.0);
}

v1::Cut cut_on_a_picture() {
  v1::Cut cut;
  v1::Circle& circle = *cut.mutable_curve()->mutable_circle();
  circle.mutable_center()->set_x(300.0);
  circle.mutable_center()->set_y(200.0);
  circle.set_radius_m(40.0);
  v1::View& view = *cut.mutable_view();
  view.mutable_camera()->mutable_eye()->set_y(-2.0);
  view.mutable_camera()->set_vertical_fov_deg(50.0);
  view.set_width_px(640.0);
  view.set_height_px(480.0);
  return cut;
}

TEST(CommandCodec, CamerasAndMatricesAreOneView) {
  v1::Cut cut = cut_on_a_picture();
  cut.mutable_view()->set_layers(v1::View::DEPTH_RANGE);
  cut.mutable_view()->set_nearest_m(1.5);
  cut.mutable_view()->set_farthest_m(2.5);
  cut.mutable_view()->set_piece(4);
  const Result<scene::Command> command = decode_cut(cut);
  ASSERT_TRUE(command.ok()) << command.error().message;
  const cut::View& view = *std::get<scene::Cut>(*command).view;
  EXPECT_EQ(view.layers, cut::LayerRule::kDepthRange);
  EXPECT_EQ(view.piece, 4);
  // The camera stands at y = -2 and looks along y with z up: the target is 2 m before it, in the middle.
  const Eigen::Vector4d target = view.view * Eigen::Vector4d(0.0, 0.0, 0.0, 1.0);
  EXPECT_NEAR(target.z(), -2.0, 1e-12);
  const Eigen::Vector4d top =
      view.projection * (view.view * Eigen::Vector4d(0.0, 0.0, 2.0 * std::tan(0.43633231), 1.0));
  EXPECT_NEAR(top.x() / top.w(), 0.0, 1e-12);
  EXPECT_NEAR(top.y() / top.w(), 1.0, 1e-6);
  // It is encoded as matrices, which mean the same again.
  const v1::Command told = encode_command(*command);
  EXPECT_EQ(told.cut().view().view_size(), 16);
  EXPECT_EQ(told.cut().view().projection_size(), 16);
  EXPECT_FALSE(told.cut().view().has_camera());
  const Result<scene::Command> again = decode_command(told);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(std::get<scene::Cut>(*again).view->view, view.view);
  EXPECT_EQ(std::get<scene::Cut>(*again).view->projection, view.projection);
  expect_equal(encode_command(*again), told);
}

TEST(CommandCodec, BadViewsAreRefusedByName) {
  const auto reason = [](const std::function<void(v1::Cut&)>& spoil) {
    v1::Cut cut = cut_on_a_picture();
    spoil(cut);
    const Result<scene::Command> command = decode_cut(cut);
    return command.ok() ? std::string("accepted") : command.error().reason + " " + command.error().field;
  };
  EXPECT_EQ(reason([](v1::Cut&) {}), "accepted");
  EXPECT_EQ(reason([](v1::Cut& c) { c.mutable_view()->clear_camera(); }), "FIELD_MISSING cut.view.camera");
  EXPECT_EQ(reason([](v1::Cut& c) { c.mutable_view()->add_view(1.0); }), "CHOICE_MISSING cut.view.camera");
  EXPECT_EQ(reason([](v1::Cut& c) {
              c.mutable_view()->clear_camera();
              c.mutable_view()->mutable_view()->Resize(15, 0.0);
            }),
            "MATRIX_SIZE cut.view.view");
  EXPECT_EQ(reason([](v1::Cut& c) {
              c.mutable_view()->clear_camera();
              c.mutable_view()->mutable_view()->Resize(16, 0.0);
            }),
            "MATRIX_SIZE cut.view.projection");
  EXPECT_EQ(reason([](v1::Cut& c) { c.mutable_view()->mutable_camera()->mutable_eye()->set_y(0.0); }),
            "CAMERA_SINGULAR cut.view.camera.up");
  EXPECT_EQ(reason([](v1::Cut& c) { c.mutable_view()->mutable_camera()->set_vertical_fov_deg(180.0); }),
            "FOV_OUT_OF_RANGE cut.view.camera.vertical_fov_deg");
  EXPECT_EQ(reason([](v1::Cut& c) { c.mutable_view()->set_layers(static_cast<v1::View::Layers>(9)); }),
            "UNKNOWN_ENUM_VALUE cut.view.layers");
  EXPECT_EQ(reason([](v1::Cut& c) { c.mutable_view()->set_width_px(0.0); }), "VIEWPORT_OUT_OF_RANGE cut.view.width_px");
  EXPECT_EQ(reason([](v1::Cut& c) { c.mutable_fit(); }), "FIT_WITH_VIEW cut.fit");
}

TEST(ReplyCodec, QualityAndCornersOfACutAreAllTold) {
  scene::CommandReply reply;
  reply.cut.emplace();
  cut::CutReport& report = reply.cut->report;
  report.refinement_stopped = true;
  report.closed_gaps = 4;
  report.widest_gap_m = 2.5e-5;
  report.merged_segments = 6;
  report.quality = {9,
                    3.5,
                    30.25,
                    6.5,
                    2.5,
                    4.5,
                    1.75,
                    1e-4,
                    7,
                    2,
                    {{{0.25, -0.5}, 12.5, 3}, {{1.0, 2.0}, 33.0, 1}},
                    5,
                    21.5,
                    {6, 2, 10.0, 11.5, 3.5}};
  const v1::CutResult result = encode_cut_result(reply, *reply.cut);
  EXPECT_EQ(result.min_angle_deg(), 3.5);
  EXPECT_TRUE(result.refinement_stopped());
  EXPECT_EQ(result.closed_gaps(), 4);
  EXPECT_EQ(result.widest_gap_m(), 2.5e-5);
  EXPECT_EQ(result.merged_segments(), 6);
  const v1::CutQuality& quality = result.quality();
  EXPECT_EQ(quality.mean_min_angle_deg(), 30.25);
  EXPECT_EQ(quality.max_aspect(), 6.5);
  EXPECT_EQ(quality.mean_aspect(), 2.5);
  EXPECT_EQ(quality.max_edge_ratio(), 4.5);
  EXPECT_EQ(quality.mean_edge_ratio(), 1.75);
  EXPECT_EQ(quality.min_height_m(), 1e-4);
  EXPECT_EQ(quality.below_angle(), 7);
  EXPECT_EQ(quality.below_contract(), 2);
  EXPECT_EQ(quality.corners_total(), 5);
  EXPECT_EQ(quality.elsewhere_min_angle_deg(), 21.5);
  EXPECT_EQ(quality.strands().below_angle(), 6);
  EXPECT_EQ(quality.strands().narrow_below_angle(), 2);
  EXPECT_EQ(quality.strands().asked_angle_deg(), 10.0);
  EXPECT_EQ(quality.strands().min_angle_deg(), 11.5);
  EXPECT_EQ(quality.strands().narrow_min_angle_deg(), 3.5);
  ASSERT_EQ(quality.corners_size(), 2);
  EXPECT_EQ(quality.corners(0).position().x(), 0.25);
  EXPECT_EQ(quality.corners(0).position().y(), -0.5);
  EXPECT_EQ(quality.corners(0).angle_deg(), 12.5);
  EXPECT_EQ(quality.corners(0).elements_below(), 3);
}

TEST(ReplyCodec, TellsOfFlagsThatWereReported) {
  fem::FlagCounts counts{};
  fem::count_flags(fem::kSubstepped | fem::kDamped, counts);
  fem::count_flags(fem::kDamped, counts);
  v1::RunResult message;
  encode_flags(counts, *message.mutable_flagged_ticks());
  EXPECT_EQ(message.flagged_ticks().size(), 2U);
  EXPECT_EQ(message.flagged_ticks().at("substepped"), 1);
  EXPECT_EQ(message.flagged_ticks().at("damped"), 2);
}

TEST(ReplyCodec, CutResultHoldsTheReport) {
  scene::CommandReply reply;
  reply.tick = 12;
  reply.topology_version = 3;
  reply.state_hash = 0xabc;
  reply.cut.emplace();
  reply.cut->status = cut::CutStatus::kApplied;
  reply.cut->report.pieces = 2;
  reply.cut->report.new_vertices = 40;
  reply.cut->report.deviation_m = 1e-4;
  reply.cut->warnings = {"one gap closed"};
  const v1::CutResult result = encode_cut_result(reply, *reply.cut);
  EXPECT_EQ(result.status(), v1::CutResult::APPLIED);
  EXPECT_EQ(result.tick(), 12);
  EXPECT_EQ(result.pieces(), 2);
  EXPECT_EQ(result.new_vertices(), 40);
  EXPECT_EQ(result.deviation_m(), 1e-4);
  EXPECT_EQ(result.state_hash(), "0000000000000abc");
  EXPECT_EQ(result.warnings(0), "one gap closed");
}

TEST(ReplyCodec, TellsOfPiecesAndOfEveryCutOfABatch) {
  scene::CommandReply reply;
  reply.batch.resize(2);
  reply.batch[1].status = cut::CutStatus::kApplied;
  scene::Piece piece;
  piece.birth = {7, 2, 3};
  piece.label = 1;
  piece.num_triangles = 12;
  piece.area = 0.25;
  piece.mass = 0.1;
  piece.centroid = {0.5, 0.125};
  piece.world_centroid = {1.0, 2.0, 3.0};
  reply.batch[1].split_pieces = {{2, {piece, piece}}};
  const std::vector<v1::CutResult> results = encode_cut_results(reply);
  ASSERT_EQ(results.size(), 2U);
  EXPECT_EQ(results[0].status(), v1::CutResult::NO_INTERSECTION);
  ASSERT_EQ(results[1].split_pieces_size(), 1);
  EXPECT_EQ(results[1].split_pieces(0).piece(), 2);
  ASSERT_EQ(results[1].split_pieces(0).children_size(), 2);
  const v1::Piece& child = results[1].split_pieces(0).children(0);
  EXPECT_EQ(child.id(), 7);
  EXPECT_EQ(child.parent(), 2);
  EXPECT_EQ(child.cut_number(), 3);
  EXPECT_EQ(child.label(), 1);
  EXPECT_EQ(child.num_triangles(), 12);
  EXPECT_EQ(child.area_m2(), 0.25);
  EXPECT_EQ(child.mass_kg(), 0.1);
  EXPECT_EQ(child.centroid().y(), 0.125);
  EXPECT_EQ(child.world_centroid().z(), 3.0);
  EXPECT_TRUE(encode_cut_results({}).empty());
}

}  // namespace
}  // namespace kerf::wire
