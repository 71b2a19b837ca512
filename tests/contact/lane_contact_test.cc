// Contact in vector code against the distances of single points, and bounds against looking at everything.
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "server/core/contact/contact_solver.h"
#include "server/core/contact/lane_contact.h"
#include "tests/contact/random_vector.h"

namespace kerf::contact {
namespace {

using Eigen::Vector3d;
using linear::VertexField;
using mesh::kVertexLanes;

Vector3d at(const std::array<mesh::VertexLanes::Lanes, 3>& field, std::size_t l) {
  return {field[0][l], field[1][l], field[2][l]};
}
void set(std::array<mesh::VertexLanes::Lanes, 3>& field, std::size_t l, const Vector3d& value) {
  for (std::size_t c = 0; c < 3; ++c) field[c][l] = value[static_cast<Eigen::Index>(c)];
}

std::vector<Collider> all_kinds() {
  return {{Plane{{0.1, 0.0, -0.2}, {0.3, -0.2, 2.0}}, 0.4},
          {Sphere{{0.1, -0.2, 0.3}, 0.7}, 0.3},
          {OrientedBox{{0.2, 0.1, -0.1}, {0.5, 0.3, 0.4}, {1.0, 2.0, -1.0}, 0.7}, 0.5},
          {OrientedBox{{0.0, 0.0, 0.0}, {0.5, 0.5, 0.5}, {0.0, 0.0, 0.0}, 0.0}, 0.0},
          {Capsule{{-0.4, 0.1, 0.0}, {0.5, 0.3, 0.2}, 0.3}, 0.2},
          {Capsule{{0.1, 0.1, 0.1}, {0.1, 0.1, 0.1}, 0.5}, 1.5}};
}

TEST(LaneContact, GapsAreThoseOfSinglePoints) {
  SeededRandom random(5);
  for (const Collider& collider : all_kinds()) {
    const PreparedCollider prepared(collider);
    for (int round = 0; round < 500; ++round) {
      mesh::VertexLanes vertices;
      ThicknessLanes thickness;
      for (std::size_t l = 0; l < kVertexLanes; ++l) {
        // The last ones on special points: centres, axes, faces.
        set(vertices.x, l, l < 13 ? random_vector(random, 1.5) : l * random_vector(random, 1e-17) + prepared.origin());
        thickness[l] = random.uniform(0.0, 0.01);
      }
      mesh::VertexLanes::Lanes gaps;
      find_gaps(prepared, thickness, vertices, gaps);
      for (std::size_t l = 0; l < kVertexLanes; ++l) {
        EXPECT_NEAR(gaps[l], prepared.query(at(vertices.x, l)).distance - thickness[l], 1e-12);
      }
    }
  }
}

// The two lines of ContactSolver's description, by the distance of one point.
void push_one(const PreparedCollider& collider, double thickness, const Vector3d& before, Vector3d& x, Vector3d& v) {
  const Proximity near = collider.query(x);
  const double depth = thickness - near.distance;
  if (!(depth > 0.0)) return;
  const Vector3d& n = near.normal;
  const auto lessened = [](const Vector3d& along, double limit) {
    const double length = along.norm();
    return length <= limit ? Vector3d(Vector3d::Zero()) : Vector3d(along * (1.0 - limit / length));
  };
  const Vector3d u = x - before;
  const Vector3d slid = u - u.dot(n) * n;
  x += lessened(slid, collider.friction() * depth) - slid + depth * n;
  const double approach = v.dot(n);
  if (approach < 0.0) v = lessened(v - approach * n, -collider.friction() * approach);
}

TEST(LaneContact, PushesAsSinglePointsArePushed) {
  SeededRandom random(6);
  for (const Collider& given_body : all_kinds()) {
    const PreparedCollider prepared(given_body);
    int num_pushed = 0;
    for (int round = 0; round < 500; ++round) {
      mesh::VertexLanes vertices;
      ThicknessLanes thickness;
      for (std::size_t l = 0; l < kVertexLanes; ++l) {
        set(vertices.x, l, random_vector(random, 1.0));
        set(vertices.v, l, random_vector(random, 3.0));
        set(vertices.before, l, at(vertices.x, l) - random.uniform(0.0, 0.1) * at(vertices.v, l));
        thickness[l] = l % 5 == 4 ? -std::numeric_limits<double>::infinity() : 1e-3;
      }
      const mesh::VertexLanes given = vertices;
      const LanePush push = push_out(prepared, thickness, vertices);
      double least_gap = std::numeric_limits<double>::infinity();
      for (std::size_t l = 0; l < kVertexLanes; ++l) {
        Vector3d x = at(given.x, l);
        Vector3d v = at(given.v, l);
        const double gap = prepared.query(x).distance - thickness[l];
        least_gap = std::min(least_gap, std::max(gap, 0.0));
        push_one(prepared, thickness[l], at(given.before, l), x, v);
        EXPECT_EQ(push.pushed >> l & 1U, gap < 0.0 ? 1U : 0U);
        // Friction is by floats: to 1e-7 of what it takes.
        EXPECT_LT((at(vertices.x, l) - x).norm(), 1e-7);
        EXPECT_LT((at(vertices.v, l) - v).norm(), 1e-6);
        EXPECT_LE((at(vertices.x, l) - at(given.x, l)).norm(), push.farthest * (1.0 + 1e-6));
        if (gap < 0.0) {
          ++num_pushed;
          if (prepared.friction() > 0.0) continue;  // which may take it into a curved body again
          EXPECT_GT(prepared.query(at(vertices.x, l)).distance, thickness[l] - 1e-12);
        } else {
          EXPECT_EQ(at(vertices.x, l), at(given.x, l));
          EXPECT_EQ(at(vertices.v, l), at(given.v, l));
        }
      }
      EXPECT_NEAR(push.least_gap, least_gap, 1e-12);
    }
    EXPECT_GT(num_pushed, 300);
  }
}

// Vertices fly about among bodies at up to 300 m/s; a solver that looks where bounds say so moves them as one that
// looks at each vertex after each substep does.
TEST(ContactBounds, MissNothingThatTouches) {
  constexpr int kVertices = 100;
  for (const double speed : {0.1, 3.0, 100.0, 300.0}) {
    const double dt = speed < 1.0 ? 1e-2 : 1e-4;
    SeededRandom random(7);
    VertexField x(kVertices);
    VertexField v(kVertices);
    for (int i = 0; i < kVertices; ++i) {
      do x.col(i) = random_vector(random, 2.0);
      while (x.col(i).norm() < 1.0);
      v.col(i) = random_vector(random, speed);
    }
    std::vector<std::uint8_t> fixed(kVertices, 0);
    fixed[3] = fixed[40] = 1;
    std::vector<Collider> bodies = all_kinds();
    for (int i = 0; i < 3; ++i) bodies.push_back({Sphere{random_vector(random, 3.0), 0.2}, 0.1});
    bodies[0].shape = Plane{{0.0, 0.0, -3.0}, {0.0, 0.0, 1.0}};
    ContactSolver bounded;
    ContactSolver thorough;
    VertexField x_thorough = x;
    VertexField v_thorough = v;
    std::int64_t num_looked_at = 0;
    std::int64_t num_substeps = 0;
    for (ContactSolver* const solver : {&bounded, &thorough}) {
      solver->set_colliders(bodies);
      solver->reserve(kVertices);
    }
    for (int tick = 0; tick < 20; ++tick) {
      bounded.begin(1e-3, fixed, x);
      thorough.begin(1e-3, fixed, x);
      for (int substep = 0; substep < 50; ++substep) {
        // Turned back towards the middle, jerkily.
        const VertexField before = x;
        for (int i = 0; i < kVertices; ++i) {
          v.col(i) += 0.05 * speed * (random_vector(random, 1.0) - 0.2 * x.col(i));
          v_thorough.col(i) = v.col(i);
        }
        x += dt * v;
        x_thorough = x;
        double travel = 0.0;
        for (int i = 0; i < kVertices; ++i) travel = std::max(travel, (x.col(i) - before.col(i)).norm());
        const std::int64_t phases = bounded.counters().phases;
        bounded.resolve(dt, before, x, v);
        num_looked_at += bounded.counters().phases - phases;
        ++num_substeps;
        thorough.find_due_blocks(0.0, 20.0);  // m, farther than any body is
        thorough.resolve(dt, before, x_thorough, v_thorough);
        ASSERT_LE((x - x_thorough).cwiseAbs().maxCoeff(), 1e-9)
            << "speed " << speed << ", tick " << tick << ", substep " << substep;
      }
    }
    EXPECT_GT(thorough.counters().contacts, 20) << speed;
    if (speed < 1.0) {
      EXPECT_LT(num_looked_at, num_substeps) << "something was left out";
    }
  }
}

// In a step that begins with a vertex inside a body, it moves out no faster than kExitSpeed, and is free from then on.
TEST(ContactSolver, BringsOutSlowlyWhatBeginsInside) {
  constexpr double kDt = 1e-3;
  constexpr double kThickness = 1e-3;
  const std::vector<Collider> bodies{{Sphere{{0.0, 0.0, 0.0}, 0.5}, 0.3}};
  ContactSolver solver;
  solver.set_colliders(bodies);
  solver.reserve(2);
  VertexField x(2);
  VertexField v = Eigen::Matrix3Xd::Zero(3, 2);
  x << 0.4, 0.0,  //
      0.0, 0.0,   //
      0.0, 0.5 + kThickness;
  int ticks = 0;
  for (; ticks < 100; ++ticks) {
    solver.begin(kThickness, {}, x);
    if (solver.num_inside() == 0) break;
    EXPECT_EQ(solver.num_inside(), 1);
    for (int i = 0; i < 16; ++i) {
      const VertexField before = x;
      v(2, 1) -= kDt * 9.81;
      x += kDt * v;
      solver.resolve(kDt, before, x, v);
      EXPECT_LT((x.col(0) - before.col(0)).norm(), kDt * ContactSolver::kExitSpeed + 1e-12);
      EXPECT_GE(x.col(1).norm(), 0.5 + kThickness - 1e-12) << "what begins outside stays outside";
    }
  }
  EXPECT_GT(ticks, 20);
  EXPECT_LT(ticks, 40);
  for (int tick = 0; tick < 3; ++tick) {
    solver.begin(kThickness, {}, x);
    EXPECT_EQ(solver.num_inside(), 0);
    const VertexField before = x;
    solver.resolve(1.0, before, x, v);
    EXPECT_GE(x.col(0).norm(), 0.5 - kThickness);
  }
}

}  // namespace
}  // namespace kerf::contact
