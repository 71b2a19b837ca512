#include "server/core/contact/impulse_response.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "server/base/random.h"
#include "tests/contact/random_vector.h"

namespace kerf::contact {
namespace {

using Eigen::Vector3d;
using mesh::VertexId;

// Two groups, each with an inverse inertia of its own along x, y and z.
class Groups : public SharedInertia {
 public:
  explicit Groups(SeededRandom& random) {
    for (std::size_t g = 0; g < members_.size(); ++g) {
      const auto n = static_cast<Eigen::Index>(members_[g].size());
      for (Eigen::MatrixXd& inverse : inverse_[g]) {
        Eigen::MatrixXd root(n, n);
        for (double& entry : root.reshaped()) entry = random.uniform(-1.0, 1.0);
        inverse = root * root.transpose();
      }
    }
  }
  [[nodiscard]] std::size_t num_groups() const override { return members_.size(); }
  [[nodiscard]] std::span<const VertexId> vertices(std::size_t group) const override { return members_[group]; }
  void respond(std::size_t group, std::size_t place, std::span<Eigen::Array3d> velocities) const override {
    ++num_calls;
    for (std::size_t k = 0; k < velocities.size(); ++k) {
      for (std::size_t c = 0; c < 3; ++c) {
        velocities[k][static_cast<Eigen::Index>(c)] =
            inverse_[group][c](static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(place));
      }
    }
  }
  // 1/kg, the response of one vertex to an impulse on another along an axis.
  [[nodiscard]] double entry(VertexId a, VertexId b, std::size_t axis) const {
    for (std::size_t g = 0; g < members_.size(); ++g) {
      const auto at = std::find(members_[g].begin(), members_[g].end(), a);
      const auto other = std::find(members_[g].begin(), members_[g].end(), b);
      if (at != members_[g].end() && other != members_[g].end()) {
        return inverse_[g][axis](at - members_[g].begin(), other - members_[g].begin());
      }
    }
    return 0.0;
  }
  mutable int num_calls = 0;

 private:
  std::array<std::vector<VertexId>, 2> members_{{{4, 1, 7}, {2, 9}}};
  std::array<std::array<Eigen::MatrixXd, 3>, 2> inverse_;
};

constexpr std::size_t kNumVertices = 12;

double own_inverse_mass(VertexId v) {
  return v == 5 ? 0.0 : 0.5 + v;
}

TEST(ImpulseResponse, IsThatOfTheInverseInertia) {
  SeededRandom random(3);
  const Groups groups(random);
  ImpulseResponse response;
  response.resize(kNumVertices);
  std::vector<double> inverse_mass(kNumVertices);
  for (std::size_t v = 0; v < kNumVertices; ++v) inverse_mass[v] = own_inverse_mass(static_cast<VertexId>(v));
  response.begin(inverse_mass, &groups);
  for (int k = 0; k < 500; ++k) {
    std::array<VertexId, 4> vertices{};
    for (std::size_t i = 0; i < 4; ++i) {
      do {
        vertices[i] = static_cast<VertexId>(random.below(kNumVertices));
      } while (std::count(vertices.begin(), vertices.begin() + static_cast<std::ptrdiff_t>(i), vertices[i]) > 0);
    }
    std::array<double, 4> weights{};
    for (double& weight : weights) weight = random.below(4) == 0 ? 0.0 : random.uniform(-1.0, 1.0);
    const Vector3d normal = random_vector(random, 1.0).normalized(), impulse = random_vector(random, 1.0);
    std::map<VertexId, Vector3d> expected, changed;
    double mobility = 0.0;
    for (VertexId v = 0; v < static_cast<VertexId>(kNumVertices); ++v) {
      Vector3d sum = Vector3d::Zero();
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
          const double entry = response.is_shared(vertices[i]) ? groups.entry(v, vertices[i], c)
                               : v == vertices[i]              ? own_inverse_mass(v)
                                                               : 0.0;
          sum[static_cast<Eigen::Index>(c)] += weights[i] * entry * impulse[static_cast<Eigen::Index>(c)];
          for (std::size_t j = 0; j < 4; ++j) {
            const auto axis = static_cast<Eigen::Index>(c);
            if (vertices[j] == v) mobility += weights[i] * weights[j] * entry * normal[axis] * normal[axis];
          }
        }
      }
      expected[v] = sum;
      changed[v] = Vector3d::Zero();
    }
    response.push(vertices, weights, impulse, [&](VertexId v, const Vector3d& change) { changed[v] += change; });
    for (const auto& [v, change] : expected) EXPECT_LT((changed[v] - change).norm(), 1e-12) << "vertex " << v;
    EXPECT_NEAR(response.mobility(vertices, weights, normal), mobility, 1e-12);
  }
  EXPECT_EQ(groups.num_calls, 5) << "once for each vertex of a group";
}

TEST(ImpulseResponse, NeverMovesWhatHasNoInverseMass) {
  SeededRandom random(4);
  const Groups groups(random);
  ImpulseResponse response;
  response.resize(kNumVertices);
  std::vector<double> inverse_mass(kNumVertices, 1.0);
  inverse_mass[1] = 0.0;  // in a group
  response.begin(inverse_mass, &groups);
  const std::array<VertexId, 2> vertices{1, 4};
  const std::array<double, 2> weights{1.0, -1.0};
  response.push(vertices, weights, Vector3d(1, 2, 3), [](VertexId v, const Vector3d&) { EXPECT_NE(v, 1); });
  EXPECT_NEAR(response.mobility(vertices, weights, Vector3d::UnitX()), groups.entry(4, 4, 0), 1e-12);
}

TEST(ImpulseResponse, ForgetsTheGroupsOfTheStepBefore) {
  SeededRandom random(5);
  const Groups groups(random);
  ImpulseResponse response;
  response.resize(kNumVertices);
  const std::vector<double> inverse_mass(kNumVertices, 2.0);
  response.begin(inverse_mass, &groups);
  EXPECT_TRUE(response.is_shared(4));
  response.begin(inverse_mass, nullptr);
  EXPECT_FALSE(response.is_shared(4));
  EXPECT_EQ(response.mobility(std::array<VertexId, 1>{4}, std::array{3.0}, Vector3d::UnitX()), 18.0);
}

}  // namespace
}  // namespace kerf::contact
