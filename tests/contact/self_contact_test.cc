// Self-contact of sheets whose vertices are free: nothing but contact holds them together or apart.
#include "server/core/contact/self_contact.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/core/contact/intersections.h"
#include "tests/contact/drift.h"
#include "tests/contact/lattice_sheet.h"
#include "tests/contact/random_vector.h"
#include "tests/support/solid_triangles.h"

namespace kerf::contact {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using mesh::VertexId;

TEST(SelfContact, StopsSquaresThatMeet) {
  constexpr int kCells = 8;
  constexpr double kEdge = 0.02;
  SeededRandom random(1);
  for (int k = 0; k < 6; ++k) {
    const mesh::TriangleMesh mesh = two_squares(kCells, kCells, kEdge);
    ASSERT_EQ(mesh.num_pieces(), 2);
    // Turned and shifted over each other; exactly one above the other at first.
    const double turn = k == 0 ? 0.0 : random.uniform(0.0, 3.0), tilt = k < 2 ? 0.0 : random.uniform(0.0, 0.1);
    const Vector3d shift = k == 0 ? Vector3d::Zero() : random_vector(random, 0.03);
    linear::VertexField x(mesh.num_vertices());
    const double half = 0.5 * kCells * kEdge;
    for (VertexId i = 0; i < mesh.num_vertices(); ++i) {
      const Vector2d p = mesh.rest_position(i);
      x.col(i) = Vector3d(p.x() - half, p.y() - half, 0.0);
      if (!is_second(mesh, i, kCells, kEdge)) continue;
      const Vector2d q(p.x() - (kCells + 1) * kEdge - half, p.y() - half);
      x.col(i) = Vector3d(std::cos(turn) * q.x() - std::sin(turn) * q.y() + shift.x(),
                          std::sin(turn) * q.x() + std::cos(turn) * q.y() + shift.y(), 0.02 + tilt * q.x());
    }
    Drift sheets(mesh, x);
    for (VertexId i = 0; i < mesh.num_vertices(); ++i) {
      const bool upper = is_second(mesh, i, kCells, kEdge);
      sheets.v.col(i) = Vector3d(upper ? 0.3 : 0.0, 0.1, upper ? -1.5 : 0.5);
      sheets.inverse_mass[static_cast<std::size_t>(i)] = upper ? 1e3 : random.uniform(500.0, 2e3);
    }
    double mass = 0.0;
    for (const double inverse : sheets.inverse_mass) mass += 1.0 / inverse;
    const Vector3d momentum = sheets.momentum();
    const double first = sheets.kinetic_energy();
    double energy = first;
    for (int step = 0; step < 3; ++step) {
      sheets.step(2e-4, 64, [&] {
        ASSERT_EQ(sheets.num_intersections(), 0) << k << ", step " << step;
        ASSERT_LT((sheets.momentum() - momentum).norm(), 1e-12 * mass * 2.0) << k;
        // Pushing apart pairs nearer than the thickness may add a little.
        ASSERT_LE(sheets.kinetic_energy(), energy * (1.0 + 1e-6)) << k << ", step " << step;
        energy = sheets.kinetic_energy();
      });
    }
    EXPECT_LT(energy, 0.7 * first) << k;
    EXPECT_GT(sheets.contact.counters().contacts, 100) << k;
  }
}

TEST(SelfContact, NeverMovesALayerThatIsHeld) {
  constexpr int kCells = 6;
  constexpr double kEdge = 0.02;
  for (const double speed : {0.5, 5.0, 50.0}) {
    const mesh::TriangleMesh mesh = two_squares(kCells, kCells, kEdge);
    linear::VertexField x(mesh.num_vertices());
    for (VertexId i = 0; i < mesh.num_vertices(); ++i) {
      const Vector2d p = mesh.rest_position(i);
      const bool upper = is_second(mesh, i, kCells, kEdge);
      x.col(i) = Vector3d(p.x() - (upper ? (kCells + 0.7) * kEdge : 0.0), p.y() + (upper ? 0.004 : 0.0),
                          upper ? 0.003 + 0.02 * p.y() : 0.0);
    }
    Drift sheets(mesh, x);
    sheets.gravity = Vector3d(0.0, 1.0, -9.81);
    for (VertexId i = 0; i < mesh.num_vertices(); ++i) {
      const bool upper = is_second(mesh, i, kCells, kEdge);
      sheets.v.col(i) = upper ? Vector3d(0.2, 0.1, -speed) : Vector3d::Zero();
      if (!upper) sheets.inverse_mass[static_cast<std::size_t>(i)] = 0.0;
    }
    for (int step = 0; step < 4; ++step) {
      sheets.step(2e-4, 40, [&] {
        ASSERT_EQ(sheets.num_intersections(), 0);
        for (VertexId i = 0; i < mesh.num_vertices(); ++i) {
          if (is_second(mesh, i, kCells, kEdge)) continue;
          ASSERT_EQ(Vector3d(sheets.x.col(i)), Vector3d(x.col(i)));
          ASSERT_EQ(Vector3d(sheets.v.col(i)), Vector3d::Zero());
          ASSERT_EQ(std::count(sheets.contact.moved().begin(), sheets.contact.moved().end(), i), 0);
        }
      });
    }
    EXPECT_GT(sheets.contact.counters().contacts, 100);
  }
}

// A square on a larger one that is held, in gravity that leans by `degrees`. Returns the way of its middle, m.
double slide(double degrees, double seconds) {
  constexpr int kLower = 16, kUpper = 5;
  constexpr double kEdge = 0.02, kStep = 1.0 / 60.0;
  constexpr int kSubsteps = 80;
  const mesh::TriangleMesh mesh = two_squares(kLower, kUpper, kEdge);
  linear::VertexField x(mesh.num_vertices());
  std::vector<VertexId> upper;
  for (VertexId i = 0; i < mesh.num_vertices(); ++i) {
    const Vector2d p = mesh.rest_position(i);
    const bool is_upper = is_second(mesh, i, kLower, kEdge);
    if (is_upper) upper.push_back(i);
    // Turned, so that no mesh line lies over another.
    const Vector2d q(p.x() - (kLower + 1) * kEdge, p.y());
    x.col(i) = is_upper ? Vector3d(0.08 + 0.8 * q.x() - 0.6 * q.y(), 0.08 + 0.6 * q.x() + 0.8 * q.y(), kApart)
                        : Vector3d(p.x(), p.y(), 0.0);
  }
  Drift sheets(mesh, x);
  const double angle = degrees * std::numbers::pi / 180.0;
  sheets.gravity = 9.81 * Vector3d(std::sin(angle), 0.0, -std::cos(angle));
  for (VertexId i = 0; i < mesh.num_vertices(); ++i) {
    if (!is_second(mesh, i, kLower, kEdge)) sheets.inverse_mass[static_cast<std::size_t>(i)] = 0.0;
  }
  for (int step = 0; step * kStep < seconds - 1e-9; ++step) sheets.step(kStep / kSubsteps, kSubsteps, [] {});
  EXPECT_EQ(sheets.num_intersections(), 0);
  double way = 0.0;
  for (const VertexId i : upper) way += (sheets.x(0, i) - x(0, i)) / static_cast<double>(upper.size());
  return way;
}

TEST(SelfContact, HoldsWhatLiesOnASlopeWithinItsFriction) {
  EXPECT_LT(std::abs(slide(16.0, 0.5)), 1e-3);
}

TEST(SelfContact, LetsWhatLiesOnASteeperSlopeSlide) {
  constexpr double kSeconds = 0.5, kFriction = 0.3;
  const double angle = 19.0 * std::numbers::pi / 180.0;
  const double expected = 0.5 * 9.81 * (std::sin(angle) - kFriction * std::cos(angle)) * kSeconds * kSeconds;
  EXPECT_NEAR(slide(19.0, kSeconds), expected, 0.05 * expected);
}

// A square whose vertices fly about, each on its own.
Drift scattered(std::uint64_t seed, int cells, double speed) {
  SeededRandom random(seed);
  const mesh::TriangleMesh mesh = LatticeSheet{.columns = cells, .rows = cells, .edge = 0.02, .is_hole = {}}.mesh();
  Drift sheet(mesh, placed(mesh, [](const Vector2d& p, int) {
                return Vector3d(p.x(), p.y(), 0.02 * std::sin(40.0 * p.x()) * std::cos(30.0 * p.y()));
              }));
  for (VertexId i = 0; i < mesh.num_vertices(); ++i) {
    const Vector3d middle(0.01 * cells, 0.01 * cells, 0.0);
    // Towards the middle, through everything that is there.
    sheet.v.col(i) = random_vector(random, speed) + speed * (middle - sheet.x.col(i)) / (0.01 * cells);
    sheet.inverse_mass[static_cast<std::size_t>(i)] = std::pow(10.0, random.uniform(2.0, 4.0));
  }
  return sheet;
}

TEST(SelfContact, LetsNothingThroughThatIsFasterThanItsResponse) {
  std::int64_t repairs = 0;
  for (const double speed : {1.0, 10.0, 50.0}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      Drift sheet = scattered(seed, 8, speed);
      for (int step = 0; step < 4; ++step) {
        int phase = 0;
        sheet.step(1e-4, 24, [&] {
          ++phase;
          ASSERT_EQ(sheet.num_intersections(), 0)
              << speed << " m/s, seed " << seed << ", step " << step << ", phase " << phase;
        });
        if (testing::Test::HasFatalFailure()) return;
      }
      EXPECT_TRUE(sheet.x.allFinite());
      EXPECT_EQ(sheet.contact.counters().unsettled, 0) << speed << " m/s, seed " << seed;
      repairs += sheet.contact.counters().repairs;
    }
  }
  EXPECT_GT(repairs, 100);
}

// Many single triangles that cross a room.
TEST(SelfContact, LetsNoTriangleThroughAnother) {
  constexpr int kTriangles = 40;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SeededRandom random(seed);
    mesh::IndexedMesh input;
    input.rest.resize(2, 3 * kTriangles);
    input.triangles.resize(3, kTriangles);
    for (int t = 0; t < kTriangles; ++t) {
      const Vector2d at(0.05 * (t % 8), 0.05 * (t / 8));  // NOLINT(bugprone-integer-division): a row
      input.rest.col(3 * t) = at;
      input.rest.col(3 * t + 1) = at + Vector2d(0.03, 0.0);
      input.rest.col(3 * t + 2) = at + Vector2d(random.uniform(0.0, 0.03), random.uniform(0.003, 0.03));
      input.triangles.col(t) = Eigen::Vector3i(3 * t, 3 * t + 1, 3 * t + 2);
    }
    const mesh::TriangleMesh mesh = test::must(mesh::import_mesh(input));
    Drift room(mesh, placed(mesh, [](const Vector2d& p, int) { return Vector3d(p.x(), p.y(), 0.0); }));
    for (int t = 0; t < kTriangles; ++t) {
      // One half comes from above, the other one from below, each triangle at a height of its own.
      const double side = t % 2 == 0 ? 1.0 : -1.0;
      const Vector3d speed(0.0, 0.0, -side * random.uniform(5.0, 30.0));
      for (const VertexId i : mesh.vertices(t)) {
        const Vector2d p = mesh.rest_position(i);
        room.x.col(i) = Vector3d(0.25 * p.x(), 0.25 * p.y(), side * (0.05 + 0.0135 * t)) + random_vector(random, 0.01);
        room.v.col(i) = speed + random_vector(random, 2.0);
      }
    }
    ASSERT_EQ(room.num_intersections(), 0);
    for (int step = 0; step < 8; ++step) {
      room.step(5e-4, 16, [&] { ASSERT_EQ(room.num_intersections(), 0) << "seed " << seed << ", step " << step; });
      if (testing::Test::HasFatalFailure()) return;
    }
    EXPECT_GT(room.contact.counters().contacts, 50) << seed;
  }
}

TEST(SelfContact, HasTheSameBitsWhenRepeated) {
  Drift first = scattered(5, 8, 10.0), second = scattered(5, 8, 10.0);
  for (int step = 0; step < 3; ++step) {
    first.step(1e-4, 24, [] {});
    // Nothing is kept from one step to the next.
    second.reset();
    second.step(1e-4, 24, [] {});
    ASSERT_EQ(first.x, second.x) << step;
    ASSERT_EQ(first.v, second.v) << step;
  }
  EXPECT_GT(first.contact.counters().contacts, 100);
}

TEST(SelfContact, LeavesVerticesThatMeetNothingAlone) {
  const mesh::TriangleMesh mesh = test::grid(10);
  Drift sheet(mesh,
              placed(mesh, [](const Vector2d& p, int) { return Vector3d(p.x(), std::sin(p.y()), std::cos(p.y())); }));
  for (VertexId i = 0; i < mesh.num_vertices(); ++i) sheet.v.col(i) = Vector3d(1.0, 2.0, 0.5 * sheet.x(0, i));
  const linear::VertexField v = sheet.v;
  sheet.step(1e-4, 64, [&] {
    EXPECT_TRUE(sheet.contact.moved().empty());
    EXPECT_EQ(sheet.v, v);
  });
  EXPECT_EQ(sheet.contact.counters().pairs, 0);
  EXPECT_EQ(sheet.contact.counters().contacts, 0);
}

// The second square lies 1 mm above the right half of the first one. What is on a border may lie on a lip.
TEST(SelfContact, FindsWhereNothingElseOfTheSheetIsNear) {
  constexpr int kCells = 8;
  constexpr double kEdge = 0.02, kSize = kCells * kEdge, kHeight = 1e-3;
  const mesh::TriangleMesh mesh = two_squares(kCells, kCells, kEdge);
  Drift sheets(mesh, placed(mesh, [](const Vector2d& p, int piece) {
                 return Vector3d(piece == 0 ? p.x() : p.x() - 0.5 * kSize - kEdge, p.y(), piece * kHeight);
               }));
  std::vector<std::uint8_t> is_apart;
  for (const double reach : {0.5 * kHeight, 2.0 * kHeight}) {
    sheets.contact.find_apart(reach, sheets.x, is_apart);
    ASSERT_EQ(is_apart.size(), static_cast<std::size_t>(mesh.num_vertices()));
    for (VertexId i = 0; i < mesh.num_vertices(); ++i) {
      if (is_second(mesh, i, kCells, kEdge)) continue;
      const Vector2d p = mesh.rest_position(i);
      const bool is_inside = p.minCoeff() > 0.5 * kEdge && p.maxCoeff() < kSize - 0.5 * kEdge;
      const bool is_below = p.x() > 0.5 * kSize - 1.5 * kEdge;  // with the triangles that reach below it
      EXPECT_EQ(is_apart[static_cast<std::size_t>(i)] != 0, is_inside && !(is_below && reach > kHeight))
          << p.transpose();
    }
  }
}

// An undo takes vertices away.
TEST(SelfContact, ForgetsTheVerticesOfTheMeshBefore) {
  const mesh::TriangleMesh mesh = two_squares(4, 4, 0.02);
  Drift sheets(mesh, placed(mesh, [](const Vector2d& p, int piece) {
                 return Vector3d(piece == 0 ? p.x() : p.x() - 0.1, p.y(), piece * kApart);
               }));
  for (VertexId i = 0; i < mesh.num_vertices(); ++i) sheets.v.col(i).z() = is_second(mesh, i, 4, 0.02) ? -1.0 : 0.0;
  sheets.contact.begin({1e-4, 8, sheets.gravity, sheets.inverse_mass}, sheets.x, sheets.v);
  EXPECT_FALSE(sheets.contact.moved().empty());
  sheets.contact.set(test::grid(3));
  EXPECT_TRUE(sheets.contact.moved().empty());
}

}  // namespace
}  // namespace kerf::contact
