// Random sequences of cuts, batches, undos and redos on sheets that move in between, through Sheet::apply. A failure
// prints the seed of its trial; run that one alone with
//   KERF_CUT_SEED=<seed> property_tests --gtest_filter='RandomUndo.*'
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/core/fem/model/model.h"
#include "server/core/sheet/sheet.h"
#include "server/core/sheet/topology.h"
#include "server/core/sheet/undo_history.h"
#include "tests/property/moving_sheets.h"
#include "tests/property/random_curves.h"
#include "tests/support/trials.h"

namespace kerf::sheet {
namespace {

struct UndoTally {
  int undos = 0, redos = 0, steps = 0, batches = 0, strips = 0;
};

// State that an undo or a redo must restore bit for bit.
struct Level {
  std::uint64_t mesh = 0;
  std::vector<std::int64_t> pieces;  // ids, by label
  double area = 0.0;                 // m^2
  double mass = 0.0;                 // kg
  bool took_material = false;        // the step that led here
};

double area_of(const mesh::TriangleMesh& mesh) {
  double area = 0.0;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (mesh.is_solid(t)) area += mesh.area(t);
  }
  return area;
}

std::vector<std::int64_t> ids_of(const Sheet& sheet) {
  std::vector<std::int64_t> ids;
  for (const scene::Piece& piece : sheet.pieces()) ids.push_back(piece.birth.id);
  return ids;
}

class Trial {
 public:
  Trial(std::uint64_t seed, UndoTally& tally) : random_(seed), tally_(tally), sheet_(make()) {
    seen_ids_.insert(0);
    note_level(0.0, false);
  }

  void run() {
    for (int i = 0; i < 24 && !::testing::Test::HasFatalFailure(); ++i) {
      const std::uint64_t what = random_.below(10);
      if (what < 2) property::stir(random_, frame_, sheet_);
      if (what == 2) sheet_.step({});
      if (what > 2 && what < 6 && sheet_.mesh().num_triangle_slots() < 1'500) cut();
      if (what == 6 || what == 7) undo();
      if (what > 7) redo();
      check_viewer();
    }
    while (at_ > 0 && !::testing::Test::HasFatalFailure()) undo();  // all the way down
  }

 private:
  Sheet make() {
    Result<Sheet> made = property::random_moving_sheet(random_, frame_);
    if (!made.ok()) ADD_FAILURE() << made.error().message;
    return std::move(made).value();
  }

  Result<scene::CommandReply> apply(scene::Command command) {
    TickReport report = sheet_.apply(std::vector<scene::Command>{std::move(command)});
    return std::move(report.replies.at(0));
  }

  // `removed`: kg, by the step that led here.
  void note_level(double removed, bool took_material) {
    const double mass = levels_.empty() ? sheet_.model().masses().total() : levels_.back().mass - removed;
    levels_.push_back({sheet_.mesh().state_hash(), ids_of(sheet_),
                       mass / (sheet_.config().material.density * sheet_.config().material.thickness), mass,
                       took_material});
  }

  void cut() {
    scene::CutBatch batch;
    const std::uint64_t num_cuts = random_.below(3) == 0 ? 1 + random_.below(4) : 1;
    for (std::uint64_t i = 0; i < num_cuts; ++i) {
      earlier_.push_back(property::random_curve(random_, sheet_.mesh(), frame_, earlier_));
      scene::Cut cut;
      cut.curve = earlier_.back();
      cut.options.max_new_triangles = 10'000;
      if (random_.below(4) == 0) cut.options.width_m = frame_.scale * std::pow(10.0, random_.uniform(-3.0, -0.5));
      batch.cuts.push_back(std::move(cut));
    }
    const std::uint64_t before = sheet_.state_hash();
    const std::size_t undone_before = sheet_.history().num_undone();
    const std::int32_t version = sheet_.topology_version();
    const bool single = num_cuts == 1 && random_.below(2) == 0;
    const Result<scene::CommandReply> reply = single ? apply(batch.cuts[0]) : apply(batch);
    if (sheet_.topology_version() == version) {
      ASSERT_EQ(sheet_.state_hash(), before) << "what was not cut changed";
      ASSERT_EQ(sheet_.history().num_undone(), undone_before);
      return;
    }
    ASSERT_TRUE(reply.ok());
    ASSERT_EQ(sheet_.topology_version(), version + 1);
    tally_.batches += single ? 0 : 1;
    ++tally_.steps;
    levels_.resize(++at_);
    double removed = 0.0;
    bool took_material = false;
    std::vector<scene::CutReply> replies = reply->batch;
    if (reply->cut) replies.push_back(*reply->cut);
    for (const scene::CutReply& done : replies) {
      removed += done.removed_mass.value_or(0.0);
      took_material = took_material || done.removed_mass.has_value();
    }
    tally_.strips += took_material ? 1 : 0;
    note_level(removed, took_material);
    ASSERT_EQ(sheet_.history().num_undone(), 0U);
    for (const std::int64_t id : levels_[at_].pieces) {
      const auto& before_ids = levels_[at_ - 1].pieces;
      if (std::find(before_ids.begin(), before_ids.end(), id) != before_ids.end()) continue;
      ASSERT_TRUE(seen_ids_.insert(id).second) << "piece id " << id << " was given twice";
    }
    check_model();
  }

  void undo() {
    const Energy before = measure();
    const Result<scene::CommandReply> reply = apply(scene::UndoCut{});
    if (at_ == 0) {
      ASSERT_FALSE(reply.ok());
      ASSERT_EQ(reply.error().reason, "NOTHING_TO_UNDO");
      return;
    }
    ASSERT_TRUE(reply.ok()) << reply.error().message;
    const bool took_material = levels_[at_].took_material;
    --at_;
    ++tally_.undos;
    check_level(before, took_material);
  }

  void redo() {
    const Energy before = measure();
    const Result<scene::CommandReply> reply = apply(scene::RedoCut{});
    if (at_ + 1 == levels_.size()) {
      ASSERT_FALSE(reply.ok());
      ASSERT_EQ(reply.error().reason, "NOTHING_TO_REDO");
      return;
    }
    ASSERT_TRUE(reply.ok()) << reply.error().message;
    ++at_;
    ++tally_.redos;
    check_level(before, levels_[at_].took_material);
  }

  struct Energy {
    Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
    double speed = 0.0;
  };
  [[nodiscard]] Energy measure() const {
    return {sheet_.model().momentum(sheet_.state()).linear, sheet_.state().v.colwise().norm().maxCoeff()};
  }

  void check_level(const Energy& before, bool changed_mass) {
    ASSERT_EQ(sheet_.mesh().find_violation(), std::nullopt);
    ASSERT_EQ(sheet_.mesh().state_hash(), levels_[at_].mesh);
    ASSERT_EQ(ids_of(sheet_), levels_[at_].pieces);
    ASSERT_EQ(sheet_.history().num_done(), at_);
    ASSERT_EQ(sheet_.history().num_undone(), levels_.size() - 1 - at_);
    check_model();
    const Energy after = measure();
    ASSERT_LE(after.speed, 2.0 * before.speed) << "an undo set something flying";
    if (!sheet_.pinned_vertices().empty() || changed_mass) return;  // which take up momentum
    ASSERT_LE((after.momentum - before.momentum).norm(), 1e-12 * levels_[at_].mass * before.speed);
  }

  void check_model() {
    const fem::Model fresh(sheet_.mesh(), sheet_.config().material);
    ASSERT_EQ(sheet_.model().hash(), fresh.hash()) << "the model is not that of the mesh";
    const fem::State& state = sheet_.state();
    ASSERT_EQ(state.x.cols(), sheet_.mesh().num_vertices());
    ASSERT_TRUE(state.x.allFinite() && state.v.allFinite());
    const auto& [hash, ids, level_area, level_mass, took_material] = levels_[at_];
    ASSERT_NEAR(fresh.masses().total(), level_mass, 1e-12 * levels_[0].mass);
    ASSERT_NEAR(area_of(sheet_.mesh()), level_area, 1e-12 * levels_[0].area);
    double mass = 0.0;
    for (const scene::Piece& piece : sheet_.pieces()) mass += piece.mass;
    ASSERT_NEAR(mass, level_mass, 1e-12 * levels_[0].mass);
    for (const mesh::VertexId v : sheet_.pinned_vertices()) {
      ASSERT_LT(v, sheet_.mesh().num_vertices());
      ASSERT_TRUE(sheet_.mesh().has_material(v));
    }
  }

  void check_viewer() {
    if (random_.below(3) == 0) return;  // a viewer may skip versions
    viewer_.follow(*sheet_.snapshot()->topology);
    const std::shared_ptr<const Topology> expected = LazyTopology().at(sheet_.mesh(), sheet_.topology_version());
    ASSERT_EQ(viewer_.triangles, expected->triangles);
    ASSERT_EQ(viewer_.pieces, expected->pieces);
    ASSERT_EQ(viewer_.material_positions, expected->material_positions);
  }

  SeededRandom random_;
  UndoTally& tally_;
  property::Frame frame_;
  Sheet sheet_;
  std::vector<cut::Curve> earlier_;
  std::vector<Level> levels_;
  std::size_t at_ = 0;  // into levels_
  std::set<std::int64_t> seen_ids_;
  property::PatchMirror viewer_;
};

void run_undo_trial(std::uint64_t seed, UndoTally& tally) {
  SCOPED_TRACE("KERF_CUT_SEED=" + std::to_string(seed));
  Trial(seed, tally).run();
}

TEST(RandomUndo, GoesBackAndForthBitForBitWhileTheMotionGoesOn) {
  UndoTally tally;
  if (const auto only = test::only_seed()) {
    run_undo_trial(*only, tally);
    return;
  }
  const int num_undos = test::num_trials({.few = 80, .usual = 300, .many = 3'000});
  for (std::uint64_t seed = test::first_seed() + 1; tally.undos < num_undos && !HasFatalFailure(); ++seed) {
    run_undo_trial(seed, tally);
  }
  if (HasFatalFailure()) return;
  std::printf("%d steps (%d of them batches, %d with strips), %d undone, %d made again\n", tally.steps, tally.batches,
              tally.strips, tally.undos, tally.redos);
  EXPECT_GT(tally.redos, tally.undos / 10);
  EXPECT_GT(tally.batches, tally.steps / 10);
  EXPECT_GT(tally.strips, tally.steps / 10);
}

}  // namespace
}  // namespace kerf::sheet
