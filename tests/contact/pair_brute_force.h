#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "server/core/contact/feature_pair.h"
#include "server/core/contact/sheet_features.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/triangle_mesh.h"
#include "tests/contact/pair_distance.h"

namespace kerf::contact {

// A sheet, its motion and how far its vertices may stray from that.
struct Moving {
  mesh::TriangleMesh mesh;
  linear::VertexField x, v;
  double duration = 6e-3;  // s
  std::vector<float> slack;

  Moving(mesh::TriangleMesh of, linear::VertexField at) : mesh(std::move(of)), x(std::move(at)), v(x.cols()) {
    v.setZero();
    slack.assign(static_cast<std::size_t>(x.cols()), static_cast<float>(std::min(1.5e-3, 0.075 * edge())));
  }
  [[nodiscard]] double edge() const { return mesh.base_edge_length(); }
};

inline Eigen::Vector3d in_plane(const Eigen::Vector2d& p) {
  return {p.x(), p.y(), 0.0};
}

// All pairs of features, and how near they come, by sampling.
class BruteForce {
 public:
  BruteForce(const SheetFeatures& features, const Moving& sheet) : features_(features), sheet_(sheet) {
    for (int k = 0; k <= kSamples; ++k) {
      at_.emplace_back(sheet.x + sheet.duration * k / kSamples * sheet.v);
    }
  }
  // Calls visit(pair) for each pair of features without a common vertex.
  template <typename Visit>
  void for_each(const Visit& visit) const {
    for (const mesh::VertexId v : features_.vertices) {
      for (std::size_t t = 0; t < features_.triangles.size(); ++t) {
        const std::array<mesh::VertexId, 3>& c = features_.triangles[t].vertices;
        if (std::find(c.begin(), c.end(), v) != c.end()) continue;
        visit(FeaturePair{
            FeaturePair::Kind::kVertexTriangle, v, static_cast<std::int32_t>(t), {v, c[0], c[1], c[2]}, 0.0, 0.0});
      }
    }
    for (std::size_t e = 0; e < features_.edges.size(); ++e) {
      for (std::size_t f = e + 1; f < features_.edges.size(); ++f) {
        const std::array<mesh::VertexId, 2>&p = features_.edges[e].vertices, &q = features_.edges[f].vertices;
        if (p[0] == q[0] || p[0] == q[1] || p[1] == q[0] || p[1] == q[1]) continue;
        visit(FeaturePair{FeaturePair::Kind::kEdgeEdge,
                          static_cast<std::int32_t>(e),
                          static_cast<std::int32_t>(f),
                          {p[0], p[1], q[0], q[1]},
                          0.0,
                          0.0});
      }
    }
  }
  [[nodiscard]] double distance_at_rest(const FeaturePair& pair) const {
    PairPositions x;
    for (std::size_t i = 0; i < 4; ++i) x[i] = in_plane(sheet_.mesh.rest_position(pair.vertices[i]));
    return wide_distance(pair.kind, x);
  }
  // m, for pairs that may come nearer than `reach`; something larger for others.
  [[nodiscard]] double least(const FeaturePair& pair, double reach) const {
    double most_slack = 0.0;
    for (const mesh::VertexId v : pair.vertices) {
      most_slack = std::max(most_slack, static_cast<double>(sheet_.slack[static_cast<std::size_t>(v)]));
    }
    double found = 1e9;
    for (const linear::VertexField& x : at_) {
      // Spheres around both sides are apart for most pairs.
      const PairPositions p = positions_of(pair, x);
      const std::size_t n = pair.num_a();
      const Eigen::Vector3d between = n == 1 ? Eigen::Vector3d(p[0] - (p[1] + p[2] + p[3]) / 3.0)
                                             : Eigen::Vector3d(p[0] + p[1] - p[2] - p[3]) / 2.0;
      double size = 0.0;
      for (std::size_t i = n; i + 1 < 4; ++i) size = std::max({size, (p[i + 1] - p[i]).norm(), (p[3] - p[n]).norm()});
      if (n == 2) size = 0.5 * size + 0.5 * (p[1] - p[0]).norm();
      if (between.norm() - size - 2.0 * most_slack > reach) continue;
      const Separation s = separation(pair.kind, p);
      double stray = 0.0;
      for (std::size_t i = 0; i < 4; ++i) {
        stray += std::abs(s.weights[i]) * static_cast<double>(sheet_.slack[static_cast<std::size_t>(pair.vertices[i])]);
      }
      found = std::min(found, s.distance - stray);
    }
    return found;
  }

 private:
  static constexpr int kSamples = 8;

  const SheetFeatures& features_;
  const Moving& sheet_;
  std::vector<linear::VertexField> at_;
};

}  // namespace kerf::contact
