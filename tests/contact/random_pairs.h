#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "server/base/random.h"
#include "server/core/contact/pair_lanes.h"
#include "server/core/contact/pair_looks.h"
#include "tests/contact/pair_distance.h"

namespace kerf::contact {

// Numbers of boxes or pairs around those that fit into vectors.
inline constexpr std::array<int, 9> kCounts{0, 1, 2, 15, 16, 17, 31, 48, 333};

// Pairs of random vertices in motion, some of which share a vertex.
struct RandomPairs {
  FeaturePair::Kind kind = FeaturePair::Kind::kVertexTriangle;
  MotionLanes motion;
  PairLanes pairs;

  RandomPairs(FeaturePair::Kind of, int count, SeededRandom& random) : kind(of) {
    constexpr std::size_t kVertices = 60;
    motion.resize(kVertices);
    for (std::size_t v = 0; v < kVertices; ++v) {
      for (std::size_t k = 0; k < 3; ++k) {
        motion.x[k][v] = static_cast<float>(random.uniform(-1.0, 1.0));
        motion.v[k][v] = static_cast<float>(random.uniform(-3.0, 3.0));
      }
      motion.slack[v] = static_cast<float>(random.uniform(0.0, 0.1));
    }
    pairs.resize(static_cast<std::size_t>(count));
    for (int p = 0; p < count; ++p) {
      std::array<mesh::VertexId, 4> ids{};
      for (mesh::VertexId& id : ids) id = static_cast<mesh::VertexId>(random.below(kVertices));
      const std::size_t n = num_a();
      // Vertices of one side differ.
      while (n == 2 && ids[1] == ids[0]) ids[1] = (ids[1] + 1) % static_cast<mesh::VertexId>(kVertices);
      while (ids[3] == ids[2] || (n == 1 && (ids[3] == ids[1] || ids[2] == ids[1]))) {
        ids[2] = static_cast<mesh::VertexId>(random.below(kVertices));
        ids[3] = static_cast<mesh::VertexId>(random.below(kVertices));
      }
      if (random.below(8) == 0) ids[n + random.below(4 - n)] = ids[random.below(n)];
      pairs.set(static_cast<std::size_t>(p), 2 * p, 3 * p + 1, ids);
    }
  }
  [[nodiscard]] std::size_t num_a() const { return kind == FeaturePair::Kind::kVertexTriangle ? 1 : 2; }
  [[nodiscard]] std::array<std::size_t, 4> ids(std::size_t p) const {
    std::array<std::size_t, 4> of{};
    for (std::size_t i = 0; i < 4; ++i) of[i] = static_cast<std::size_t>(pairs.vertices[i][p]);
    return of;
  }
  [[nodiscard]] PairPositions positions(std::size_t p) const {
    PairPositions x;
    const auto of = ids(p);
    for (std::size_t i = 0; i < 4; ++i) x[i] = vector(motion.x, of[i]);
    return x;
  }
  [[nodiscard]] static Eigen::Vector3d vector(const FloatLanes& field, std::size_t v) {
    return {static_cast<double>(field[0][v]), static_cast<double>(field[1][v]), static_cast<double>(field[2][v])};
  }
  [[nodiscard]] bool shares_a_vertex(std::size_t p) const {
    const auto of = ids(p);
    for (std::size_t i = 0; i < num_a(); ++i) {
      if (std::find(of.begin() + static_cast<std::ptrdiff_t>(num_a()), of.end(), of[i]) != of.end()) return true;
    }
    return false;
  }
  // m/s, of corners of both sides against each other.
  [[nodiscard]] double fastest(std::size_t p) const {
    const auto of = ids(p);
    double fastest = 0.0;
    for (std::size_t i = 0; i < num_a(); ++i) {
      for (std::size_t j = num_a(); j < 4; ++j) {
        fastest = std::max(fastest, (vector(motion.v, of[i]) - vector(motion.v, of[j])).norm());
      }
    }
    return fastest;
  }
  // m, distance less what both sides can come nearer by.
  [[nodiscard]] double least(std::size_t p, double duration) const {
    const auto of = ids(p);
    double slack_a = 0.0, slack_b = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      double& slack = i < num_a() ? slack_a : slack_b;
      slack = std::max(slack, static_cast<double>(motion.slack[of[i]]));
    }
    return wide_distance(kind, positions(p)) - slack_a - slack_b - duration * fastest(p);
  }
};

}  // namespace kerf::contact
