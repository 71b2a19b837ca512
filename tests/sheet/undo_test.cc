// Undo and redo of cuts, and batches of cuts.
#include <algorithm>

#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/sheet/recording.h"
#include "server/core/sheet/undo_history.h"
#include "tests/sheet/calls.h"

namespace kerf::sheet {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

scene::SheetConfig free_sheet(std::int32_t n) {
  scene::SheetConfig config = scenes::hanging(n);
  config.pins.clear();
  return config;
}

// Thrown into the air, turning and straining.
Sheet flying(std::int32_t n) {
  Sheet sheet = make(free_sheet(n));
  EXPECT_TRUE(apply(sheet, scene::Grab{"hand", 0, Vector3d(0.03, 0.05, 0.02), 0.0}).ok());
  run(sheet, 6);
  EXPECT_TRUE(apply(sheet, scene::Release{"hand"}).ok());
  return sheet;
}

scene::Cut across() {
  return scenes::line_cut({-0.1, 0.47}, {1.1, 0.53});
}
scene::Cut slit() {
  return scenes::bezier_cut({0.2, 0.5}, {0.4, 0.8}, {0.6, 0.2}, {0.8, 0.5});
}

TEST(UndoCut, RightAfterTheCutGivesTheSheetBackAsItWas) {
  Sheet sheet = flying(16);
  const fem::State before = sheet.state();
  const std::uint64_t mesh = sheet.mesh().state_hash();
  const std::uint64_t model = sheet.model().hash();
  const fem::Momentum momentum = sheet.model().momentum(before);
  ASSERT_TRUE(apply(sheet, slit()).ok());
  const Result<scene::CommandReply> undone = apply(sheet, scene::UndoCut{});
  ASSERT_TRUE(undone.ok()) << undone.error().message;
  EXPECT_EQ(sheet.mesh().state_hash(), mesh);
  EXPECT_EQ(sheet.model().hash(), model);
  ASSERT_EQ(sheet.state().x.cols(), before.x.cols());
  int same = 0;
  for (Eigen::Index v = 0; v < before.x.cols(); ++v) same += before.x.col(v) == sheet.state().x.col(v) ? 1 : 0;
  EXPECT_GT(same, before.x.cols() * 3 / 4) << "only vertices that the cut relaxed may have been interpolated";
  EXPECT_LT((sheet.state().x - before.x).colwise().norm().maxCoeff(), 2e-3);
  const double scale = sheet.model().masses().total() * before.v.colwise().norm().maxCoeff();
  EXPECT_LT((sheet.model().momentum(sheet.state()).linear - momentum.linear).norm(), 1e-12 * scale);
  EXPECT_LT((sheet.model().centre_of_mass(sheet.state().x) - sheet.model().centre_of_mass(before.x)).norm(), 1e-4);
  EXPECT_EQ(undone->topology_version, 3) << "versions count on";
  EXPECT_EQ(undone->state_hash, sheet.state_hash());
}

TEST(UndoCut, ClosesLipsAtTheirMeanWeightedByMass) {
  Sheet sheet = make(free_sheet(9));
  ASSERT_TRUE(apply(sheet, across()).ok());
  ASSERT_EQ(sheet.mesh().num_pieces(), 2);
  EXPECT_TRUE(apply(sheet, scene::SetWind{scene::Wind{{0.0, 20.0, 5.0}, 1.2, 1.0}}).ok());
  EXPECT_TRUE(apply(sheet, scene::Grab{"hand", 0, Vector3d(-0.2, -0.3, 0.0), 0.0}).ok());
  run(sheet, 20);
  const fem::State before = sheet.state();
  const fem::Model model = sheet.model();
  const std::vector<scene::Piece> pieces = sheet.pieces();
  ASSERT_GT((pieces[0].world_centroid - pieces[1].world_centroid).norm(), 0.51) << "the pieces have not parted";
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(sheet.mesh().num_pieces(), 1);
  const double speed = before.v.colwise().norm().maxCoeff();
  EXPECT_LT((sheet.model().momentum(sheet.state()).linear - model.momentum(before).linear).norm(),
            1e-12 * model.masses().total() * speed);
  EXPECT_LE(sheet.state().v.colwise().norm().maxCoeff(), 1.2 * speed);
  run(sheet, 60);
  EXPECT_FALSE(sheet.frozen());
  EXPECT_TRUE(sheet.state().x.allFinite());
}

TEST(UndoCut, RedoMakesTheSameMeshAgain) {
  Sheet sheet = flying(14);
  std::vector<std::uint64_t> meshes{sheet.mesh().state_hash()};
  for (const scene::Cut& cut : scenes::three_cuts()) {
    ASSERT_TRUE(apply(sheet, cut).ok());
    meshes.push_back(sheet.mesh().state_hash());
    run(sheet, 3);
  }
  for (std::size_t level = 3; level-- > 0;) {
    const Result<scene::CommandReply> undone = apply(sheet, scene::UndoCut{});
    ASSERT_TRUE(undone.ok());
    EXPECT_EQ(undone->undone->cuts, std::vector<std::int64_t>{static_cast<std::int64_t>(level) + 1});
    EXPECT_EQ(undone->undone->undo_steps, static_cast<std::int32_t>(level));
    EXPECT_EQ(undone->undone->redo_steps, static_cast<std::int32_t>(3 - level));
    EXPECT_EQ(sheet.mesh().state_hash(), meshes[level]);
    run(sheet, 2);
  }
  EXPECT_EQ(reason(apply(sheet, scene::UndoCut{})), "NOTHING_TO_UNDO");
  for (std::size_t level = 1; level <= 3; ++level) {
    const Result<scene::CommandReply> redone = apply(sheet, scene::RedoCut{});
    ASSERT_TRUE(redone.ok());
    EXPECT_EQ(redone->undone->cuts, std::vector<std::int64_t>{static_cast<std::int64_t>(level)});
    EXPECT_EQ(redone->undone->pieces, sheet.mesh().num_pieces());
    EXPECT_EQ(sheet.mesh().state_hash(), meshes[level]);
    run(sheet, 2);
  }
  EXPECT_EQ(reason(apply(sheet, scene::RedoCut{})), "NOTHING_TO_REDO");
}

TEST(UndoCut, ARefusalChangesNothing) {
  Sheet sheet = flying(8);
  const std::uint64_t hash = sheet.state_hash();
  const Result<scene::CommandReply> undone = apply(sheet, scene::UndoCut{});
  ASSERT_FALSE(undone.ok());
  EXPECT_EQ(undone.error().code, ErrorCode::kFailedPrecondition);
  EXPECT_EQ(reason(apply(sheet, scene::RedoCut{})), "NOTHING_TO_REDO");
  EXPECT_EQ(sheet.state_hash(), hash);
  EXPECT_EQ(sheet.topology_version(), 1);
}

TEST(UndoCut, ANewCutAndAResetDropWhatCouldBeMadeAgain) {
  Sheet sheet = make(scenes::hanging(10));
  ASSERT_TRUE(apply(sheet, across()).ok());
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  ASSERT_TRUE(apply(sheet, scenes::line_cut({5.0, 5.0}, {6.0, 6.0})).ok());  // misses: no cut
  EXPECT_EQ(sheet.history().num_undone(), 1U);
  ASSERT_TRUE(apply(sheet, slit()).ok());
  EXPECT_EQ(reason(apply(sheet, scene::RedoCut{})), "NOTHING_TO_REDO");
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
  EXPECT_EQ(reason(apply(sheet, scene::RedoCut{})), "NOTHING_TO_REDO");
}

TEST(UndoCut, PinsThatACutGaveVanishAndWhatAPinnedVertexJoinsStaysHeld) {
  Sheet sheet = make(scenes::hanging(11));
  const std::vector<mesh::VertexId> pinned = sheet.pinned_vertices();
  const scene::Cut down = scenes::line_cut({0.52, 1.2}, {0.48, -0.2});  // through the pinned edge
  ASSERT_TRUE(apply(sheet, down).ok());
  ASSERT_GT(sheet.pinned_vertices().size(), pinned.size());
  run(sheet, 10);
  const Eigen::Matrix3Xd x = sheet.state().x;
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(sheet.pinned_vertices(), pinned);
  for (const mesh::VertexId v : pinned) EXPECT_EQ(sheet.state().x.col(v), x.col(v)) << v;

  // Only the copy of a vertex on the new lip is held: the vertex that it becomes part of is, then, too.
  ASSERT_TRUE(apply(sheet, scene::SetPins{}).ok());
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.5, 1.2}, {0.5, -0.2})).ok());  // along the grid's edges
  const mesh::VertexId copy = sheet.mesh().num_vertices() - 1;
  ASSERT_TRUE(apply(sheet, scene::SetPins{{std::vector<mesh::VertexId>{copy}}}).ok());
  run(sheet, 10);
  const Vector3d held = sheet.state().x.col(copy);
  const Vector2d where = sheet.mesh().rest_position(copy);
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  ASSERT_EQ(sheet.pinned_vertices().size(), 1U);
  const mesh::VertexId joined = sheet.pinned_vertices().front();
  EXPECT_EQ(sheet.mesh().rest_position(joined), where);
  EXPECT_EQ(Vector3d(sheet.state().x.col(joined)), held);
}

TEST(UndoCut, GrabsFollow) {
  Sheet sheet = make(scenes::hanging(11));
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.5, 1.2}, {0.5, -0.2})).ok());
  const mesh::VertexId copy = sheet.mesh().num_vertices() - 1;
  const Vector2d copy_at = sheet.mesh().rest_position(copy);
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.13, 0.22}, {0.37, 0.41})).ok());
  const mesh::VertexId made = sheet.mesh().num_vertices() - 1;  // a point of its own
  const Vector2d made_at = sheet.mesh().rest_position(made);
  ASSERT_TRUE(apply(sheet, scene::Grab{"copy", copy, std::nullopt, 0.0}).ok());
  ASSERT_TRUE(apply(sheet, scene::Grab{"made", made, std::nullopt, 0.0}).ok());
  ASSERT_TRUE(apply(sheet, scene::Grab{"point", Vector2d(0.25, 0.3), std::nullopt, 0.0}).ok());
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  const auto held_at = [&](const GrabState& grab) {
    Vector2d at = Vector2d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      if (grab.vertices[k] == mesh::kNone) continue;
      EXPECT_LT(grab.vertices[k], sheet.mesh().num_vertices());
      at += grab.weights[static_cast<Eigen::Index>(k)] * sheet.mesh().rest_position(grab.vertices[k]);
    }
    return at;
  };
  ASSERT_EQ(sheet.grabs().size(), 3U);
  EXPECT_EQ(held_at(sheet.grabs()[0]), copy_at);
  EXPECT_FALSE(sheet.grabs()[0].material) << "it still holds a vertex";
  EXPECT_LT((held_at(sheet.grabs()[1]) - made_at).norm(), 1e-9);
  EXPECT_LT((held_at(sheet.grabs()[2]) - Vector2d(0.25, 0.3)).norm(), 1e-9);
  run(sheet, 20);
  EXPECT_FALSE(sheet.frozen());
}

TEST(UndoHistory, IsBoundInSteps) {
  UndoHistory history;
  const auto add = [&](std::int64_t number) {
    std::vector<DoneCut> cuts(1);
    cuts[0].number = number;
    history.add(std::move(cuts));
  };
  const auto limit = static_cast<std::int64_t>(UndoHistory::kMaxSteps);
  for (std::int64_t number = 1; number <= limit; ++number) add(number);
  EXPECT_EQ(history.num_done(), UndoHistory::kMaxSteps);
  add(limit + 1);
  EXPECT_EQ(history.num_done(), UndoHistory::kMaxSteps);
  for (std::int64_t number = limit + 1; number > 1; --number) {
    const Result<std::shared_ptr<const UndoStep>> step = history.take_done();
    ASSERT_TRUE(step.ok());
    EXPECT_EQ((*step)->cuts[0].number, number);
  }
  EXPECT_EQ(history.take_done().error().reason, "UNDO_FORGOTTEN");
  for (std::int64_t number = 2; number <= limit + 1; ++number) {
    EXPECT_EQ(history.take_undone().value()->cuts[0].number, number);
  }
  EXPECT_EQ(history.take_undone().error().reason, "NOTHING_TO_REDO");
}

TEST(UndoHistory, IsBoundInBytes) {
  UndoHistory history;
  const auto step = [](std::size_t bytes) {
    std::vector<DoneCut> cuts(1);
    cuts[0].edit.undo.triangles.resize(bytes / sizeof(cuts[0].edit.undo.triangles[0]));
    return cuts;
  };
  history.add(step(UndoHistory::kMaxBytes / 2));
  history.add(step(UndoHistory::kMaxBytes / 3));
  EXPECT_EQ(history.num_done(), 2U);
  history.add(step(UndoHistory::kMaxBytes / 3));
  EXPECT_EQ(history.num_done(), 2U) << "the oldest goes";
  ASSERT_TRUE(history.take_done().ok());
  ASSERT_TRUE(history.take_done().ok());
  EXPECT_EQ(history.take_done().error().reason, "UNDO_FORGOTTEN");
  EXPECT_EQ(history.num_undone(), 2U);
  history.add(step(2 * UndoHistory::kMaxBytes));
  EXPECT_EQ(history.num_done(), 0U);
  EXPECT_EQ(history.num_undone(), 0U);
  EXPECT_EQ(history.bytes(), 0U);
  history.clear();
  EXPECT_EQ(history.take_done().error().reason, "NOTHING_TO_UNDO");
}

TEST(UndoCut, IsReplayedBitForBit) {
  Recorder recorder;
  Sheet sheet = make(scenes::hanging(12));
  recorder.start(sheet.config());
  const auto tick = [&](std::vector<scene::Command> commands) {
    sheet.step(commands);
    recorder.append({sheet.tick(), std::move(commands), sheet.state_hash()});
  };
  for (int round = 0; round < 3; ++round) {
    tick({slit(), scene::CutBatch{{across(), scenes::circle_cut({0.3, 0.3}, 0.1)}}});
    tick({});
    tick({scene::UndoCut{}});
    tick({scene::UndoCut{}, scene::RedoCut{}});
    tick({scene::RedoCut{}});
    tick({scene::UndoCut{}, scene::UndoCut{}});
  }
  const Result<ReplayReport> report = replay(recorder.recording());
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_FALSE(report->divergence);
  EXPECT_EQ(report->ticks, 18);
}

TEST(UndoCut, ACopyOfASheetUndoesAsTheSheetDoes) {
  Sheet sheet = flying(10);
  ASSERT_TRUE(apply(sheet, slit()).ok());
  ASSERT_TRUE(apply(sheet, across()).ok());
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  Sheet copy = sheet;
  for (Sheet* each : {&sheet, &copy}) {
    ASSERT_TRUE(apply(*each, scene::RedoCut{}).ok());
    ASSERT_TRUE(apply(*each, scene::UndoCut{}).ok());
    ASSERT_TRUE(apply(*each, scene::UndoCut{}).ok());
    run(*each, 3);
  }
  EXPECT_EQ(copy.state_hash(), sheet.state_hash());
}

TEST(CutBatch, MakesTheMeshThatTheCutsOneByOneMake) {
  Sheet one_by_one = flying(16);
  Sheet at_once = one_by_one;
  for (const scene::Cut& cut : scenes::three_cuts()) ASSERT_TRUE(apply(one_by_one, cut).ok());
  const Result<scene::CommandReply> reply = apply(at_once, scene::CutBatch{scenes::three_cuts()});
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(at_once.mesh().state_hash(), one_by_one.mesh().state_hash());
  EXPECT_EQ(at_once.model().hash(), one_by_one.model().hash());
  EXPECT_LT((at_once.state().x - one_by_one.state().x).colwise().norm().maxCoeff(), 1e-12);
  // Velocities are corrected once, over all that the cuts touched, in place of three times.
  const double speed = one_by_one.state().v.colwise().norm().maxCoeff();
  EXPECT_LT((at_once.state().v - one_by_one.state().v).colwise().norm().maxCoeff(), 0.02 * speed);
  EXPECT_EQ(at_once.topology_version(), 2) << "one version for all";
  EXPECT_EQ(at_once.history().num_done(), 1U) << "one step to undo";
  EXPECT_EQ(at_once.num_cuts(), 3);
  ASSERT_EQ(reply->batch.size(), 3U);
  EXPECT_EQ(reply->batch[0].number, 1);
  EXPECT_EQ(reply->batch[2].number, 3);
  EXPECT_EQ(reply->batch[0].report.pieces, 1);
  EXPECT_EQ(reply->batch[1].report.pieces, 2);
  EXPECT_EQ(reply->batch[2].report.pieces, 3);
  ASSERT_TRUE(apply(at_once, scene::UndoCut{}).ok());
  EXPECT_EQ(at_once.mesh().num_pieces(), 1);
}

TEST(CutBatch, ConservesMomentumAndPinsWhatItShould) {
  Sheet sheet = flying(12);
  const fem::Momentum before = sheet.model().momentum(sheet.state());
  const double scale = sheet.model().masses().total() * sheet.state().v.colwise().norm().maxCoeff();
  ASSERT_TRUE(apply(sheet, scene::CutBatch{scenes::three_cuts()}).ok());
  EXPECT_LT((sheet.model().momentum(sheet.state()).linear - before.linear).norm(), 1e-12 * scale);

  // The second cut splits a vertex that the first one made on the pinned edge.
  Sheet one_by_one = make(scenes::hanging(9));
  Sheet at_once = one_by_one;
  const std::vector<scene::Cut> cuts{scenes::line_cut({0.55, 1.2}, {0.55, 0.4}),
                                     scenes::line_cut({0.52, 1.2}, {0.58, 0.4})};
  for (const scene::Cut& cut : cuts) ASSERT_TRUE(apply(one_by_one, cut).ok());
  ASSERT_TRUE(apply(at_once, scene::CutBatch{cuts}).ok());
  EXPECT_EQ(at_once.mesh().state_hash(), one_by_one.mesh().state_hash());
  EXPECT_EQ(at_once.pinned_vertices(), one_by_one.pinned_vertices());
}

TEST(CutBatch, IsDoneWholeOrNotAtAllAndNamesTheCutThatFailed) {
  Sheet sheet = flying(10);
  ASSERT_TRUE(apply(sheet, slit()).ok());
  const std::uint64_t hash = sheet.state_hash();
  const std::uint64_t model = sheet.model().hash();
  const std::int32_t version = sheet.topology_version();
  scene::CutBatch batch{scenes::three_cuts()};
  batch.cuts.push_back(scenes::line_cut({0.11, -0.1}, {0.13, 1.1}));
  batch.cuts.back().options.max_new_triangles = 1;
  const Result<scene::CommandReply> refused = apply(sheet, batch);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().reason, "CUT_ELEMENT_BUDGET");
  EXPECT_EQ(refused.error().field, "cut_batch.cuts[3]");
  EXPECT_EQ(sheet.state_hash(), hash);
  EXPECT_EQ(sheet.model().hash(), model);
  EXPECT_EQ(sheet.topology_version(), version);
  EXPECT_EQ(sheet.history().num_done(), 1U);

  batch.cuts[1].options.tolerance = 7.0;
  const Result<scene::CommandReply> invalid = apply(sheet, batch);
  ASSERT_FALSE(invalid.ok());
  EXPECT_EQ(invalid.error().field, "cut_batch.cuts[1].tolerance");
  EXPECT_EQ(sheet.state_hash(), hash);
}

TEST(CutBatch, TakesAsManyCutsAsItsLimitSays) {
  scene::CutBatch batch;
  EXPECT_EQ(validate(scene::Command(batch)).error().reason, "EMPTY");
  batch.cuts.assign(scene::kMaxBatchCuts, scenes::line_cut({0.1, 0.1}, {0.2, 0.2}));
  EXPECT_TRUE(validate(scene::Command(batch)).ok());
  batch.cuts.push_back(batch.cuts.front());
  const Status beyond = validate(scene::Command(batch));
  ASSERT_FALSE(beyond.ok());
  EXPECT_EQ(beyond.error().field, "cut_batch.cuts");
}

TEST(CutBatch, HoldsAKirigamiOfAThousandCuts) {
  scene::CutBatch batch;
  for (int row = 0; row < 40; ++row) {
    for (int column = 0; column < 25; ++column) {
      const double x = (column + (row % 2 == 0 ? 0.1 : 0.55)) / 26.0;
      const double y = (row + 0.5) / 40.0;
      batch.cuts.push_back(scenes::line_cut({x, y}, {x + 0.028, y}));
    }
  }
  Sheet sheet = make(scenes::hanging(30));
  const std::uint64_t before = sheet.mesh().state_hash();
  const Result<scene::CommandReply> reply = apply(sheet, batch);
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  ASSERT_EQ(reply->batch.size(), 1000U);
  for (const scene::CutReply& cut : reply->batch) EXPECT_EQ(cut.status, cut::CutStatus::kApplied);
  EXPECT_EQ(sheet.mesh().num_pieces(), 1);
  EXPECT_EQ(sheet.model().hash(), fem::Model(sheet.mesh(), sheet.config().material).hash());
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(sheet.mesh().state_hash(), before);
}

TEST(CutBatch, OfMissesOnlyIsNoStep) {
  Sheet sheet = make(scenes::hanging(6));
  const std::uint64_t hash = sheet.state_hash();
  const scene::Cut miss = scenes::line_cut({2.0, 0.0}, {3.0, 1.0});
  const Result<scene::CommandReply> reply = apply(sheet, scene::CutBatch{{miss, miss}});
  ASSERT_TRUE(reply.ok());
  EXPECT_EQ(reply->batch.size(), 2U);
  EXPECT_EQ(reply->batch[1].status, cut::CutStatus::kNoIntersection);
  EXPECT_EQ(sheet.state_hash(), hash);
  EXPECT_EQ(sheet.history().num_done(), 0U);
}

}  // namespace
}  // namespace kerf::sheet
