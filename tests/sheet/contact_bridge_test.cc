#include "server/core/sheet/contact_bridge.h"
#include "server/core/fem/element/contact_constraint.h"

#include <array>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/sheet/calls.h"

namespace kerf::sheet {
namespace {

// Horizontal planes; the origin lies 5, 1, 4, 2 and 3 m above them.
ContactBridge over_five_planes(const std::vector<mesh::VertexId>& pinned) {
  std::vector<contact::Collider> colliders;
  for (const double below : {5.0, 1.0, 4.0, 2.0, 3.0}) {
    colliders.push_back({contact::Plane{{0.0, 0.0, -below}, {0.0, 0.0, 1.0}}, 0.1 * below});
  }
  ContactBridge bridge;
  bridge.set_colliders(colliders);
  bridge.set_half_thickness(0.25);
  bridge.set_vertices(2, pinned, {});
  bridge.begin(Eigen::Matrix3Xd::Zero(3, 2));
  return bridge;
}

TEST(ContactBridge, OfManySurfacesTheNearestAreKeptInTheirOrder) {
  std::array<fem::SurfaceGap, fem::ContactConstraint::kMaxGaps> gaps;
  ASSERT_EQ(over_five_planes({}).find_gaps(0, Eigen::Vector3d::Zero(), kInfinity, gaps), 3U);
  EXPECT_EQ(gaps[0].surface, 1);
  EXPECT_EQ(gaps[0].gap, 0.75);
  EXPECT_EQ(gaps[0].friction, 0.1);
  EXPECT_EQ(gaps[1].surface, 3);
  EXPECT_EQ(gaps[1].gap, 1.75);
  EXPECT_EQ(gaps[2].surface, 4);
  EXPECT_EQ(gaps[2].gap, 2.75);
}

TEST(ContactBridge, SurfacesBeyondReachAreLeftOut) {
  std::array<fem::SurfaceGap, fem::ContactConstraint::kMaxGaps> gaps;
  const ContactBridge bridge = over_five_planes({});
  ASSERT_EQ(bridge.find_gaps(0, Eigen::Vector3d::Zero(), 2.0, gaps), 2U);
  EXPECT_EQ(gaps[0].surface, 1);
  EXPECT_EQ(gaps[1].surface, 3);
  EXPECT_EQ(bridge.find_gaps(0, Eigen::Vector3d::Zero(), 0.0, gaps), 0U);
}

TEST(ContactBridge, APinTouchesNothing) {
  std::array<fem::SurfaceGap, fem::ContactConstraint::kMaxGaps> gaps;
  const ContactBridge bridge = over_five_planes({1});
  EXPECT_EQ(bridge.find_gaps(1, Eigen::Vector3d::Zero(), kInfinity, gaps), 0U);
}

}  // namespace
}  // namespace kerf::sheet
