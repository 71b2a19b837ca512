#include "server/core/fem/leapfrog/cluster_push.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "server/base/random.h"
#include "server/core/fem/step/explicit_integrator.h"
#include "server/core/linear/lanes16.h"
#include "tests/fem/cut_sheet.h"
#include "tests/support/trials.h"

namespace kerf::fem {
namespace {

template <typename T>
class ClusterPushOf : public testing::Test {
 protected:
  // x 4, of each vertex of a cluster.
  struct Values {
    std::vector<linear::Lanes16<T>> lanes;
    explicit Values(std::size_t vertices) : lanes(vertices / 4 + 1) {}
    T* data() { return lanes.front().lane.data(); }
    T& at(std::size_t i, std::size_t c) { return data()[4 * i + c]; }
  };

  ClusterPushOf() : sheet_(50), integrator_(explicit_options(Precision::kDouble)) {}
  void SetUp() override {
    integrator_.rebuild(sheet_.model);
    push_.reserve(integrator_.inertia().largest());
    ASSERT_GT(clusters().size(), 5U);
  }
  std::span<InertiaCluster* const> clusters() const { return integrator_.inertia().clusters(); }

  // J, v.M' v / 2.
  double energy(const InertiaCluster& cluster, const std::vector<double>& v) const {
    double twice = 0.0;
    std::vector<std::size_t> place(static_cast<std::size_t>(sheet_.mesh.num_vertices()), 0);
    for (std::size_t i = 0; i < cluster.vertices().size(); ++i) {
      place[static_cast<std::size_t>(cluster.vertices()[i])] = i;
    }
    const auto dot = [&](std::size_t i, std::size_t j) {
      return v[3 * i] * v[3 * j] + v[3 * i + 1] * v[3 * j + 1] + v[3 * i + 2] * v[3 * j + 2];
    };
    for (std::size_t i = 0; i < cluster.vertices().size(); ++i) twice += cluster.mass(i) * dot(i, i);
    cluster.for_each_added([&](mesh::VertexId a, mesh::VertexId b, double entry) {
      const std::size_t i = place[static_cast<std::size_t>(a)], j = place[static_cast<std::size_t>(b)];
      twice += (i == j ? 1.0 : 2.0) * entry * dot(i, j);
    });
    return 0.5 * twice;
  }

  CutSheet sheet_;
  ExplicitIntegrator integrator_;
  ClusterPush<T> push_;
  const double tolerance_ = std::is_same_v<T, float> ? 1e-3 : 1e-9;  // -
};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(ClusterPushOf, Precisions);

TYPED_TEST(ClusterPushOf, OneVertexMovesAsWanted) {
  for (const InertiaCluster* const cluster : this->clusters()) {
    for (std::size_t pushed = 0; pushed < cluster->vertices().size(); ++pushed) {
      typename TestFixture::Values wanted(cluster->vertices().size());
      for (std::size_t c = 0; c < 3; ++c)
        wanted.at(pushed, c) = static_cast<TypeParam>(1e-6 * static_cast<double>(1 + c));
      const TypeParam* const response = this->push_.respond(*cluster, wanted.data());
      for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(static_cast<double>(response[4 * pushed + c]), 1e-6 * static_cast<double>(1 + c),
                    1e-6 * this->tolerance_);
      }
    }
  }
}

TYPED_TEST(ClusterPushOf, AFreeClusterMovesAsAWhole) {
  for (const InertiaCluster* const cluster : this->clusters()) {
    ASSERT_FALSE(cluster->is_held());
    typename TestFixture::Values wanted(cluster->vertices().size());
    for (std::size_t i = 0; i < cluster->vertices().size(); ++i) wanted.at(i, 2) = 3;
    const TypeParam* const response = this->push_.respond(*cluster, wanted.data());
    for (std::size_t i = 0; i < cluster->vertices().size(); ++i) {
      EXPECT_EQ(response[4 * i], 0);
      EXPECT_NEAR(static_cast<double>(response[4 * i + 2]), 3.0, 3.0 * this->tolerance_);
    }
  }
}

// Bodies with any normals stop some vertices.
TYPED_TEST(ClusterPushOf, StoppingSomeVerticesTakesEnergy) {
  SeededRandom random(test::first_seed() + 1);
  const auto any_direction = [&] {
    Eigen::Vector3d n;
    do {
      n = {random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)};
    } while (!(n.norm() > 0.1));
    return Eigen::Vector3d(n.normalized());
  };
  for (const InertiaCluster* const cluster : this->clusters()) {
    const std::size_t n = cluster->vertices().size();
    for (int trial = 0; trial < test::num_trials({.few = 2, .usual = 10, .many = 100}); ++trial) {
      // Some move together, as flakes that fall do, and others each by themselves.
      const Eigen::Vector3d together = trial % 2 == 0 ? Eigen::Vector3d(0.3, -0.2, -5.0) : Eigen::Vector3d::Zero();
      std::vector<double> v(3 * n);
      typename TestFixture::Values wanted(n);
      double stopped = 0.0;  // J, of the masses that are stopped
      double largest = 0.0;
      for (std::size_t i = 0; i < n; ++i) {
        const Eigen::Vector3d velocity = together + any_direction();
        const Eigen::Vector3d normal = any_direction();
        const double approach = std::min(velocity.dot(normal), 0.0);
        for (std::size_t c = 0; c < 3; ++c) v[3 * i + c] = velocity[static_cast<Eigen::Index>(c)];
        if (random.below(3) != 0) continue;
        for (std::size_t c = 0; c < 3; ++c) {
          wanted.at(i, c) = static_cast<TypeParam>(-approach * normal[static_cast<Eigen::Index>(c)]);
          largest = std::max(largest, std::abs(static_cast<double>(wanted.at(i, c))));
        }
        stopped += 0.5 * cluster->mass(i) * approach * approach;
      }
      const double before = this->energy(*cluster, v);
      const TypeParam* const response = this->push_.respond(*cluster, wanted.data());
      for (std::size_t i = 0; i < n; ++i) {
        const bool is_pushed = wanted.at(i, 0) != 0;
        for (std::size_t c = 0; c < 3; ++c) {
          v[3 * i + c] += static_cast<double>(response[4 * i + c]);
          if (is_pushed) {
            EXPECT_LE(std::abs(static_cast<double>(response[4 * i + c])), largest * (1.0 + 1e-6));
          }
        }
      }
      EXPECT_LE(this->energy(*cluster, v), before - 0.5 * stopped + 1e-6 * before);
    }
  }
}

TYPED_TEST(ClusterPushOf, WhatIsHeldStays) {
  for (InertiaCluster* const cluster : this->clusters()) {
    const std::size_t n = cluster->vertices().size();
    std::vector<std::uint8_t> held(n, 0);
    for (const std::uint8_t of_first : {std::uint8_t{0b111}, std::uint8_t{0b100}}) {
      held[0] = of_first;
      cluster->hold(held);
      typename TestFixture::Values wanted(n);
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t c = 0; c < 3; ++c) wanted.at(i, c) = 1;
      }
      const TypeParam* const response = this->push_.respond(*cluster, wanted.data());
      for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(response[c] == 0, (of_first >> c & 1U) != 0) << c;
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NE(response[4 * (n - 1) + c], 0);
      EXPECT_TRUE(std::all_of(response, response + 4 * n, [](TypeParam each) { return std::isfinite(each); }));
    }
  }
}

}  // namespace
}  // namespace kerf::fem
