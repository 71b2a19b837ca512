// Long random sequences of operations: sound after every commit, and taken back bit for bit.

#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/mesh/mesh_editor.h"
#include "tests/mesh/edit_checks.h"
#include "tests/support/meshes.h"

namespace kerf::mesh {
namespace {

class RandomOperations {
 public:
  RandomOperations(const TriangleMesh& mesh, MeshEditor& editor, SeededRandom& random)
      : mesh_(mesh), editor_(editor), random_(random) {}

  void apply_one() {
    switch (random_.below(8)) {
      case 0:
        return insert();
      case 1:
        return split_edge();
      case 2:
        return (void)editor_.flip_edge(slot(), corner());
      case 3:
        return move();
      case 4:
        return cut_walk();
      case 5:
        return recover();
      case 6:
        return cut_from_lip();
      default:
        return (void)editor_.legalise(sheet_point());
    }
  }

 private:
  std::int32_t below(std::int32_t bound) {
    return static_cast<std::int32_t>(random_.below(static_cast<std::uint64_t>(bound)));
  }
  TriangleId slot() { return below(mesh_.num_triangle_slots()); }
  TriangleId solid_slot() {
    for (;;) {
      const TriangleId t = slot();
      if (mesh_.is_solid(t)) return t;
    }
  }
  int corner() { return below(3); }
  PointId sheet_point() { return mesh_.points(solid_slot())[corner()]; }

  LatticePoint between(const LatticePoint& a, const LatticePoint& b, double share) {
    return {a.x + std::llrint(share * static_cast<double>(b.x - a.x)),
            a.y + std::llrint(share * static_cast<double>(b.y - a.y))};
  }

  void insert() {
    const std::array<PointId, 3> p = mesh_.points(solid_slot());
    const LatticePoint on_edge = between(mesh_.at(p[0]), mesh_.at(p[1]), random_.uniform(0.05, 0.95));
    const PointId added = editor_.insert_point(between(on_edge, mesh_.at(p[2]), random_.uniform(0.0, 0.95)));
    if (added != kNone && random_.below(2) == 0) editor_.legalise(added);
  }

  void split_edge() {
    const TriangleId t = solid_slot();
    const int k = corner();
    const LatticePoint& a = mesh_.at(mesh_.points(t)[next_corner(k)]);
    const LatticePoint& b = mesh_.at(mesh_.points(t)[previous_corner(k)]);
    const PointId added = editor_.split_edge(t, k, between(a, b, random_.uniform(0.1, 0.9)));
    if (added != kNone && random_.below(2) == 0) editor_.legalise(added);
  }

  void move() {
    const TriangleId t = solid_slot();
    const PointId p = mesh_.points(t)[0];
    (void)editor_.move_point(p, between(mesh_.at(p), mesh_.at(mesh_.points(t)[1]), random_.uniform(0.0, 0.6)));
  }

  // Cuts along a walk over edges.
  void cut_walk() {
    PointId p = sheet_point();
    std::vector<TriangleId> fan;
    for (std::uint64_t left = 1 + random_.below(6); left > 0; --left) {
      mesh_.fan_around(p, fan);
      const TriangleId t = fan[random_.below(fan.size())];
      const int c = mesh_.corner_of(t, p);
      (void)editor_.lock_edge(t, previous_corner(c), kLockCut);
      if (!mesh_.is_solid(t)) return;
      p = mesh_.points(t)[next_corner(c)];
    }
  }

  void recover() {
    const PointId p = sheet_point();
    const PointId q = sheet_point();
    if (p == q) return;
    const Recovery made = editor_.recover_edge(p, q, random_.below(2) == 0 ? kLockCut : LockBits{0});
    EXPECT_NE(made.status, Recovery::Status::kLimit);
  }

  // A T: puts a point on a locked edge if it finds one, and cuts away from it.
  void cut_from_lip() {
    for (int tries = 0; tries < 20; ++tries) {
      const TriangleId t = solid_slot();
      const int k = corner();
      if (mesh_.locks(t, k) == 0) continue;
      const PointId apex = mesh_.points(t)[k];
      const LatticePoint& a = mesh_.at(mesh_.points(t)[next_corner(k)]);
      const LatticePoint& b = mesh_.at(mesh_.points(t)[previous_corner(k)]);
      const PointId p = editor_.split_edge(t, k, between(a, b, random_.uniform(0.2, 0.8)));
      if (p != kNone) (void)editor_.recover_edge(p, apex, kLockCut);
      return;
    }
  }

  const TriangleMesh& mesh_;
  MeshEditor& editor_;
  SeededRandom& random_;
};

void run_sequences(const TriangleMesh& start, std::uint64_t seed, int num_edits, std::uint64_t longest) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  SeededRandom random(seed);
  TriangleMesh mesh = start;
  std::vector<std::pair<std::uint64_t, UndoLog>> history;
  for (int i = 0; i < num_edits; ++i) {
    const TriangleMesh before = mesh;
    MeshEditor editor(mesh);
    RandomOperations operations(mesh, editor, random);
    const std::uint64_t length = 1 + random.below(longest);
    for (std::uint64_t step = 0; step < length; ++step) {
      operations.apply_one();
      if (random.below(8) == 0) editor.open();
    }
    if (random.below(4) == 0) {
      editor.rollback();
      ASSERT_TRUE(mesh == before) << "rollback of edit " << i;
      ASSERT_EQ(mesh.state_hash(), before.state_hash());
      continue;
    }
    CommittedEdit done = editor.commit();
    test::expect_sound(before, mesh, done.edit);
    if (testing::Test::HasFatalFailure() || testing::Test::HasNonfatalFailure()) {
      ADD_FAILURE() << "in edit " << i;
      return;
    }
    TriangleMesh undone = mesh;
    done.undo.undo(undone);
    ASSERT_TRUE(undone == before) << "undo of edit " << i;
    history.emplace_back(before.state_hash(), std::move(done.undo));
  }
  while (!history.empty()) {  // and all of it, one after the other
    history.back().second.undo(mesh);
    ASSERT_EQ(mesh.state_hash(), history.back().first);
    history.pop_back();
  }
  EXPECT_TRUE(mesh == start);
}

TEST(RandomEdits, SingleOperationsAreSoundAndUndone) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) run_sequences(test::jittered_grid(6, seed), seed, 100, 1);
}

TEST(RandomEdits, LongEditsAreSoundAndUndone) {
  for (std::uint64_t seed = 100; seed < 300; ++seed) run_sequences(test::grid(8), seed, 12, 40);
}

TEST(RandomEdits, TheZooSurvives) {
  for (const test::ZooMesh& animal : test::zoo()) {
    SCOPED_TRACE(animal.name);
    const TriangleMesh start = test::must(import_mesh(animal.sheet));
    for (std::uint64_t seed = 1000; seed < 1040; ++seed) run_sequences(start, seed, 12, 12);
  }
}

TEST(RandomEdits, TheSameOperationsGiveTheSameBits) {
  std::vector<std::uint64_t> hashes;
  for (int run = 0; run < 2; ++run) {
    TriangleMesh mesh = test::jittered_grid(10, 77);
    SeededRandom random(5);
    MeshEditor editor(mesh);
    RandomOperations operations(mesh, editor, random);
    for (int i = 0; i < 200; ++i) operations.apply_one();
    (void)editor.commit();
    EXPECT_EQ(mesh.find_violation(), std::nullopt);
    hashes.push_back(mesh.state_hash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

// Cuts of a single edge inside: both ends are tips, so the opened mesh has no vertex twice there.
std::int32_t num_lone_slits(const TriangleMesh& mesh) {
  std::int32_t num_sides = 0;
  for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    for (int k = 0; k < 3; ++k) {
      if ((mesh.locks(t, k) & kLockCut) == 0) continue;
      const TriangleId n = mesh.welded_neighbour(t, k);
      const int m = mesh.mirror_corner(t, k);
      num_sides += mesh.vertices(t)[next_corner(k)] == mesh.vertices(n)[previous_corner(m)] &&
                   mesh.vertices(t)[previous_corner(k)] == mesh.vertices(n)[next_corner(m)];
    }
  }
  return num_sides / 2;
}

// The opened mesh suffices to weld it again, except for slits that opened nothing. Operations at random places leave a
// triangle too flat for import now and then.
TEST(RandomEdits, AnOpenedMeshCanBeImportedAgain) {
  int num_too_flat = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    TriangleMesh mesh = test::jittered_grid(9, seed);
    SeededRandom random(seed);
    MeshEditor editor(mesh);
    RandomOperations operations(mesh, editor, random);
    for (int i = 0; i < 60; ++i) operations.apply_one();
    (void)editor.commit();
    IndexedMesh opened;
    opened.rest.resize(2, mesh.num_vertices());
    for (VertexId v = 0; v < mesh.num_vertices(); ++v) opened.rest.col(v) = mesh.rest_position(v);
    opened.triangles.resize(3, mesh.num_solid_triangles());
    Eigen::Index column = 0;
    for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
      if (!mesh.is_solid(t)) continue;
      opened.triangles.col(column++) = Eigen::Vector3i(mesh.vertices(t)[0], mesh.vertices(t)[1], mesh.vertices(t)[2]);
    }
    const Result<TriangleMesh> again = import_mesh(opened);
    if (!again.ok() && again.error().reason == "MESH_DEGENERATE_TRIANGLE") {
      ++num_too_flat;
      continue;
    }
    ASSERT_TRUE(again.ok()) << again.error().message;
    EXPECT_EQ(again->find_violation(), std::nullopt);
    EXPECT_EQ(again->num_pieces(), mesh.num_pieces());
    EXPECT_EQ(again->num_boundary_loops(), mesh.num_boundary_loops() - num_lone_slits(mesh));
  }
  EXPECT_LE(num_too_flat, 20);
}

}  // namespace
}  // namespace kerf::mesh
