#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "server/core/contact/collider.h"
#include "server/core/contact/contact_solver.h"
#include "tests/contact/random_vector.h"

namespace kerf::contact {
namespace {

using Eigen::Vector3d;
using linear::VertexField;

constexpr double kTight = 1e-12;

void expect_proximity(const Shape& shape, const Vector3d& point, double distance, const Vector3d& normal) {
  const Proximity near = PreparedCollider({shape, 0.0}).query(point);
  EXPECT_NEAR(near.distance, distance, kTight) << "at " << point.transpose();
  EXPECT_NEAR((near.normal - normal).norm(), 0.0, kTight) << "normal " << near.normal.transpose();
}

TEST(Collider, PlaneDistanceIsSignedAndScaleFree) {
  const Plane plane{{0.0, 0.0, 1.0}, {0.0, 0.0, 250.0}};
  expect_proximity(plane, {3.0, -2.0, 1.5}, 0.5, {0, 0, 1});
  expect_proximity(plane, {3.0, -2.0, 0.25}, -0.75, {0, 0, 1});
  const Plane tilted{{0.0, 0.0, 0.0}, {1.0, 1.0, 0.0}};
  expect_proximity(tilted, {1.0, 1.0, 7.0}, std::sqrt(2.0), Vector3d(1, 1, 0).normalized());
  expect_proximity(Plane{{0, 0, 0}, {0, 0, 1e-200}}, {0, 0, 2}, 2.0, {0, 0, 1});
}

TEST(Collider, SphereDistanceInsideOutsideAndAtTheCentre) {
  const Sphere sphere{{1.0, 0.0, 0.0}, 0.5};
  expect_proximity(sphere, {3.0, 0.0, 0.0}, 1.5, {1, 0, 0});
  expect_proximity(sphere, {1.0, -0.25, 0.0}, -0.25, {0, -1, 0});
  expect_proximity(sphere, {1.0, 0.0, 0.0}, -0.5, {0, 0, 1});
}

TEST(Collider, BoxDistanceToFaceEdgeCornerAndFromInside) {
  const OrientedBox box{{0.0, 0.0, 0.0}, {1.0, 2.0, 3.0}, {0.0, 0.0, 0.0}, 0.0};
  expect_proximity(box, {1.5, 0.3, -0.4}, 0.5, {1, 0, 0});
  expect_proximity(box, {-1.3, 2.4, 1.0}, 0.5, {-0.6, 0.8, 0.0});
  expect_proximity(box, {2.0, 4.0, 5.0}, 3.0, Vector3d(1, 2, 2) / 3.0);
  expect_proximity(box, {0.2, -1.9, 0.0}, -0.1, {0, -1, 0});
  expect_proximity(box, {0.0, 0.0, 0.0}, -1.0, {1, 0, 0});
  expect_proximity(box, {1.0, 0.0, 0.0}, 0.0, {1, 0, 0});
}

TEST(Collider, RotatedBoxEqualsTheUnrotatedOneInItsFrame) {
  const OrientedBox straight{{0.0, 0.0, 0.0}, {0.3, 0.2, 0.1}, {0.0, 0.0, 0.0}, 0.0};
  const Vector3d axis(1.0, -2.0, 0.5);
  const OrientedBox turned{{0.4, 0.5, 0.6}, {0.3, 0.2, 0.1}, 7.0 * axis, 1.1};
  const Eigen::Matrix3d R = Eigen::AngleAxisd(1.1, axis.normalized()).toRotationMatrix();
  SeededRandom random(5);
  for (int i = 0; i < 500; ++i) {
    const Vector3d local = random_vector(random, 0.5);
    const Proximity expected = PreparedCollider({straight, 0.0}).query(local);
    const Proximity actual = PreparedCollider({turned, 0.0}).query(turned.centre + R * local);
    EXPECT_NEAR(actual.distance, expected.distance, kTight);
    EXPECT_NEAR((actual.normal - R * expected.normal).norm(), 0.0, 1e-9);
  }
}

TEST(Collider, CapsuleDistanceAlongTheAxisAtTheEndsAndDegenerate) {
  const Capsule capsule{{0.0, 0.0, 0.0}, {0.0, 0.0, 2.0}, 0.5};
  expect_proximity(capsule, {2.0, 0.0, 1.0}, 1.5, {1, 0, 0});
  expect_proximity(capsule, {0.0, 0.0, 3.0}, 0.5, {0, 0, 1});
  expect_proximity(capsule, {0.0, 0.3, -0.4}, 0.0, {0.0, 0.6, -0.8});
  expect_proximity(capsule, {0.1, 0.0, 1.0}, -0.4, {1, 0, 0});
  const Proximity on_axis = PreparedCollider({capsule, 0.0}).query({0.0, 0.0, 1.0});
  EXPECT_DOUBLE_EQ(on_axis.distance, -0.5);
  EXPECT_NEAR(on_axis.normal.norm(), 1.0, kTight);
  EXPECT_NEAR(on_axis.normal.z(), 0.0, kTight);
  expect_proximity(Capsule{{1, 1, 1}, {1, 1, 1}, 0.5}, {1, 1, 3}, 1.5, {0, 0, 1});
  expect_proximity(Capsule{{1, 1, 1}, {1, 1, 1}, 0.5}, {1, 1, 1}, -0.5, {0, 0, 1});
}

TEST(Collider, NormalIsTheGradientOfTheDistance) {
  const std::vector<Shape> shapes{Plane{{0.1, 0.2, 0.3}, {1.0, -2.0, 0.3}}, Sphere{{0.1, 0.0, -0.1}, 0.4},
                                  OrientedBox{{0.0, 0.1, 0.0}, {0.3, 0.5, 0.4}, {1.0, 1.0, 0.2}, 0.7},
                                  Capsule{{-0.2, 0.0, 0.1}, {0.3, 0.2, 0.0}, 0.25}};
  SeededRandom random(11);
  constexpr double kStep = 1e-6;
  for (const Shape& shape : shapes) {
    const PreparedCollider collider({shape, 0.0});
    int kinks = 0;
    for (int i = 0; i < 400; ++i) {
      const Vector3d p = random_vector(random, 1.0);
      const Proximity near = collider.query(p);
      Vector3d gradient;
      for (int k = 0; k < 3; ++k) {
        const Vector3d d = kStep * Vector3d::Unit(k);
        gradient[k] = (collider.query(p + d).distance - collider.query(p - d).distance) / (2.0 * kStep);
      }
      if ((gradient - near.normal).norm() > 1e-4) ++kinks;
    }
    EXPECT_LE(kinks, 1);  // inside a box the nearest face may change within the difference
  }
}

TEST(Collider, RefusesBadValuesAndNamesTheField) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto field = [](const Collider& collider) {
    const Status status = validate(collider, "colliders[2]");
    return status.ok() ? std::string("accepted") : status.error().field;
  };
  EXPECT_EQ(field({Sphere{}, 0.3}), "accepted");
  EXPECT_EQ(field({Plane{{0, nan, 0}, {0, 0, 1}}, 0.0}), "colliders[2].plane.point.y");
  EXPECT_EQ(field({Plane{{0, 0, 0}, {0, 0, 0}}, 0.0}), "colliders[2].plane.normal");
  EXPECT_EQ(field({Sphere{{0, 0, 2e6}, 1.0}, 0.0}), "colliders[2].sphere.center.z");
  EXPECT_EQ(field({Sphere{{0, 0, 0}, 0.0}, 0.0}), "colliders[2].sphere.radius_m");
  EXPECT_EQ(field({Sphere{{0, 0, 0}, 1.1e4}, 0.0}), "colliders[2].sphere.radius_m");
  EXPECT_EQ(field({OrientedBox{{0, 0, 0}, {1, -1, 1}, {0, 0, 1}, 0.0}, 0.0}), "colliders[2].box.half_extents_m.y");
  EXPECT_EQ(field({OrientedBox{{0, 0, 0}, {1, 1, 1}, {0, 0, 1}, nan}, 0.0}), "colliders[2].box.angle_rad");
  EXPECT_EQ(field({Capsule{{0, 0, 0}, {0, nan, 1}, 1.0}, 0.0}), "colliders[2].capsule.b.y");
  EXPECT_EQ(field({Sphere{}, -0.1}), "colliders[2].friction");
  EXPECT_EQ(field({Sphere{}, 10.5}), "colliders[2].friction");
}

void set_colliders(ContactSolver& solver, const std::vector<Collider>& colliders) {
  solver.set_colliders(colliders);
  solver.reserve(4);
}

// One free particle under gravity, by symplectic Euler.
struct Particle {
  VertexField x{1};
  VertexField v = Eigen::Matrix3Xd::Zero(3, 1);

  void step(ContactSolver& solver, double dt, double thickness) {
    const VertexField before = x;
    solver.begin(thickness, {}, before);
    v.col(0) += dt * Vector3d(0.0, 0.0, -9.81);
    x += dt * v;
    solver.resolve(dt, before, x, v);
  }
};

// Resolves vertices that were outside of all bodies when the step began, and then moved from `before` to `x`.
void resolve(ContactSolver& solver, double thickness, const std::vector<std::uint8_t>& fixed, const VertexField& before,
             VertexField& x, VertexField& v) {
  constexpr double kFarAway = 1e5;  // m
  solver.begin(thickness, fixed, (x.array() + kFarAway).matrix());
  solver.find_due_blocks(0.0, 3.0 * kFarAway);
  solver.resolve(1e-3, before, x, v);
}

TEST(ContactSolver, RestsOnAPlaneAtItsThickness) {
  ContactSolver solver;
  const std::vector<Collider> floor{{Plane{}, 0.5}};
  set_colliders(solver, floor);
  Particle particle;
  particle.x.col(0) = Vector3d(0.0, 0.0, 0.3);
  for (int i = 0; i < 1000; ++i) particle.step(solver, 1e-3, 2e-3);
  EXPECT_NEAR(particle.x(2, 0), 2e-3, kTight);
  EXPECT_NEAR(particle.v.norm(), 0.0, kTight);
  EXPECT_LT(solver.counters().phases, 1000);  // not while it fell
  EXPECT_GT(solver.counters().phases, 500);
  EXPECT_GT(solver.counters().contacts, 500);
}

TEST(ContactSolver, SticksOnAnInclineExactlyWhereTheTangentIsBelowMu) {
  constexpr double kMu = 0.5;
  constexpr double kSeconds = 1.0;
  constexpr double kDt = 1e-3;
  for (const double tangent : {0.3, 0.49, 0.51, 0.8}) {
    const double angle = std::atan(tangent);
    const Vector3d normal(std::sin(angle), 0.0, std::cos(angle));
    ContactSolver solver;
    const std::vector<Collider> incline{{Plane{{0, 0, 0}, normal}, kMu}};
    set_colliders(solver, incline);
    Particle particle;
    particle.x.col(0).setZero();
    for (int i = 0; i < static_cast<int>(kSeconds / kDt); ++i) particle.step(solver, kDt, 0.0);
    const double slid = particle.x.col(0).norm();
    if (tangent < kMu) {
      EXPECT_LT(slid, 1e-9) << "tangent " << tangent;
    } else {
      // Down the slope with g (sin - mu cos), first-order in the step.
      const double acceleration = 9.81 * (std::sin(angle) - kMu * std::cos(angle));
      EXPECT_NEAR(slid, 0.5 * acceleration * kSeconds * kSeconds, 2.0 * acceleration * kDt) << "tangent " << tangent;
    }
  }
}

TEST(ContactSolver, FrictionlessContactKeepsTheTangentialVelocity) {
  ContactSolver solver;
  const std::vector<Collider> floor{{Plane{}, 0.0}};
  set_colliders(solver, floor);
  VertexField x(1);
  x << 0.0, 0.0, -0.01;
  VertexField v(1);
  v << 1.0, -2.0, -3.0;
  const VertexField before = Eigen::Matrix3Xd::Zero(3, 1);
  resolve(solver, 0.0, {}, before, x, v);
  EXPECT_EQ(Vector3d(x.col(0)), Vector3d(0, 0, 0));
  EXPECT_EQ(Vector3d(v.col(0)), Vector3d(1, -2, 0));
}

TEST(ContactSolver, NeverAddsKineticEnergy) {
  ContactSolver solver;
  const std::vector<Collider> bodies{{Sphere{{0, 0, 0}, 0.5}, 0.4},
                                     {OrientedBox{{0.3, 0, 0}, {0.4, 0.2, 0.3}, {0, 1, 1}, 0.5}, 1.5},
                                     {Capsule{{-0.5, 0, 0}, {0.5, 0.5, 0}, 0.2}, 0.0}};
  set_colliders(solver, bodies);
  SeededRandom random(3);
  for (int i = 0; i < 1000; ++i) {
    VertexField x(1);
    VertexField v(1);
    x.col(0) = random_vector(random, 0.6);
    v.col(0) = random_vector(random, 5.0);
    const VertexField before = x - 1e-3 * v;
    const double speed = v.norm();
    resolve(solver, 1e-3, {}, before, x, v);
    EXPECT_LE(v.norm(), speed * (1.0 + 1e-14));
  }
}

TEST(ContactSolver, LeavesFixedVerticesAndFarOnesAlone) {
  ContactSolver solver;
  const std::vector<Collider> bodies{{Sphere{}, 0.0}};
  set_colliders(solver, bodies);
  VertexField x(3);
  x << 0.0, 0.5, 3.0,  //
      0.0, 0.0, 0.0,   //
      0.1, 0.0, 0.0;
  VertexField v = Eigen::Matrix3Xd::Constant(3, 3, -1.0);
  const VertexField x_before = x;
  const VertexField v_before = v;
  const std::vector<std::uint8_t> fixed{1, 0, 0};
  resolve(solver, 0.0, fixed, x_before, x, v);
  EXPECT_EQ(Vector3d(x.col(0)), Vector3d(x_before.col(0)));
  EXPECT_EQ(Vector3d(v.col(0)), Vector3d(v_before.col(0)));
  EXPECT_NEAR(x.col(1).norm(), 1.0, kTight);
  EXPECT_EQ(Vector3d(x.col(2)), Vector3d(x_before.col(2)));
}

TEST(ContactSolver, DoesNothingAndCountsNothingWithoutColliders) {
  ContactSolver solver;
  solver.reserve(4);
  VertexField x = Eigen::Matrix3Xd::Constant(3, 4, -1.0);
  VertexField v = x;
  const VertexField before = x;
  resolve(solver, 0.1, {}, before, x, v);
  EXPECT_TRUE(solver.empty());
  EXPECT_EQ(solver.counters().phases, 0);
  EXPECT_TRUE(x == before && v == before);
}

TEST(ContactSolver, EndsOutsideBothWallsOfANotch) {
  ContactSolver solver;
  const std::vector<Collider> notch{{Plane{{0, 0, 0}, {1.0, 0.0, 1.0}}, 0.3},
                                    {Plane{{0, 0, 0}, {-1.0, 0.0, 1.0}}, 0.3}};
  set_colliders(solver, notch);
  Particle particle;
  particle.x.col(0) = Vector3d(0.02, 0.0, 0.5);
  for (int i = 0; i < 2000; ++i) particle.step(solver, 1e-3, 0.0);
  for (const Collider& wall : notch) {
    EXPECT_GT(PreparedCollider(wall).query(particle.x.col(0)).distance, -1e-5);
  }
  EXPECT_LT(particle.v.norm(), 0.05);
}

// Two planes that meet in the y axis and leave `angle` (rad) of room between them, upwards.
std::vector<Collider> notch(double angle, double friction) {
  const double c = std::cos(0.5 * angle);
  const double s = std::sin(0.5 * angle);
  return {{Plane{{0, 0, 0}, {c, 0.0, s}}, friction}, {Plane{{0, 0, 0}, {-c, 0.0, s}}, friction}};
}

double least_distance(const std::vector<Collider>& bodies, const Vector3d& x) {
  double least = std::numeric_limits<double>::infinity();
  for (const Collider& body : bodies) least = std::min(least, PreparedCollider(body).query(x).distance);
  return least;
}

TEST(ContactSolver, EndsOutsideBothWallsHoweverNarrowTheNotch) {
  constexpr double kThickness = 1e-3;
  for (const double degrees : {120.0, 60.0, 20.0, 5.0, 1.0}) {
    const double angle = degrees * std::numbers::pi / 180.0;
    for (const double friction : {0.0, 0.3}) {
      ContactSolver solver;
      const std::vector<Collider> walls = notch(angle, friction);
      set_colliders(solver, walls);
      Particle particle;
      particle.x.col(0) = Vector3d(0.01 * std::tan(0.5 * angle), 0.0, 0.3);
      for (int i = 0; i < 2000; ++i) {
        particle.step(solver, 1e-3, kThickness);
        ASSERT_GT(least_distance(walls, particle.x.col(0)), kThickness - 2e-9) << degrees << " degrees, step " << i;
      }
      // No deeper than a ball of that radius goes.
      EXPECT_GT(particle.x(2, 0), kThickness / std::sin(0.5 * angle) - 1e-6) << degrees;
      if (friction > 0.0) continue;  // it may stick higher up
      // In a wide one what stops it at the second wall lifts it off the first, by what a step of gravity makes.
      const bool is_narrow = degrees < 90.0;
      EXPECT_NEAR(particle.x(2, 0), kThickness / std::sin(0.5 * angle), is_narrow ? 1e-6 : 1e-5) << degrees;
      EXPECT_LT(particle.v.norm(), is_narrow ? 1e-9 : 0.01) << degrees;
    }
  }
}

TEST(ContactSolver, EndsOutsideASphereAndThePlaneItStandsOn) {
  constexpr double kThickness = 1e-3;
  const std::vector<Collider> bodies{{Plane{}, 0.2}, {Sphere{{0.0, 0.0, 0.5}, 0.5}, 0.2}};
  ContactSolver solver;
  set_colliders(solver, bodies);
  SeededRandom random(8);
  for (int i = 0; i < 500; ++i) {
    // In the cusp around the point of contact, which leaves room for the sheet from 4.5 cm on.
    const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
    const double radius = random.uniform(0.01, 0.06);
    VertexField x(1);
    VertexField v(1);
    x.col(0) = Vector3d(radius * std::cos(angle), radius * std::sin(angle), random.uniform(-0.001, 0.003));
    v.col(0) = random_vector(random, 1.0);
    const VertexField before = x;
    const double speed = v.norm();
    resolve(solver, kThickness, {}, before, x, v);
    EXPECT_GT(least_distance(bodies, x.col(0)), kThickness - 2e-9) << i;
    EXPECT_LE(v.norm(), speed * (1.0 + 1e-14));
  }
}

TEST(ContactSolver, ThreeWallsAndAGapWithoutRoomStayBounded) {
  constexpr double kThickness = 1e-3;
  ContactSolver solver;
  std::vector<Collider> walls = notch(0.35, 0.1);
  walls.push_back({Plane{{0, 0, 0}, {0.0, 1.0, 0.2}}, 0.1});
  set_colliders(solver, walls);
  Particle particle;
  particle.x.col(0) = Vector3d(0.0, 0.05, 0.2);
  for (int i = 0; i < 1000; ++i) particle.step(solver, 1e-3, kThickness);
  EXPECT_GT(least_distance(walls, particle.x.col(0)), kThickness - 1e-6);

  const std::vector<Collider> vice{{Plane{}, 0.0}, {Plane{{0, 0, 1e-3}, {0.0, 0.0, -1.0}}, 0.0}};
  set_colliders(solver, vice);
  particle.x.col(0) = Vector3d(0.0, 0.0, 5e-4);
  particle.v.setZero();
  for (int i = 0; i < 1000; ++i) particle.step(solver, 1e-3, kThickness);
  EXPECT_LT(std::abs(particle.x(2, 0)), 3e-3);
  EXPECT_LT(particle.x.col(0).head<2>().norm(), 1e-12);
}

}  // namespace
}  // namespace kerf::contact
