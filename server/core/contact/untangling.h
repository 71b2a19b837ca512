#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/contact/contours.h"
#include "server/core/contact/feature_pair.h"
#include "server/core/contact/impulse_response.h"
#include "server/core/contact/intersections.h"
#include "server/core/contact/sheet_features.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"

namespace kerf::contact {

// Triangles of a sheet that pass through each other: which pairs of features they open, and impulses that pull them
// apart. Distances have no sign, so contact would keep such triangles as they are.
class Untangling {
 public:
  // Must be called after each change of the topology. Allocates memory.
  void set(const SheetFeatures& features);

  // Returns the number of pairs of triangles that pass through each other at positions x, m. The last answer is kept.
  std::int64_t count(const linear::VertexField& x);
  // Says that count() would return 0 at positions x, m.
  void know_none(const linear::VertexField& x);

  // Begins a step at positions x, m: finds what passes through what, and which way it comes apart.
  void begin(const SheetFeatures& features, const linear::VertexField& x);
  // Returns true if nothing passes through anything.
  [[nodiscard]] bool empty() const { return pairs_.empty(); }
  // Returns true if a pair of features has a vertex each of two triangles that pass through each other. Such a pair has
  // no contact.
  [[nodiscard]] bool is_open(const FeaturePair& pair) const;

  // Sets the impulses for edges that pass through triangles at positions x (m) and velocities v (m/s), for an interval
  // (s). `thickness`: m, distance that the middle surfaces keep.
  void find_pushes(const SheetFeatures& features, const linear::VertexField& x, const linear::VertexField& v,
                   double thickness, double interval, ImpulseResponse& response);
  void clear_pushes() { pushes_.clear(); }
  // Changes velocities v (m/s) so that edges leave the triangles that they pass through. Calls mark(vertex) for each
  // vertex that it moves.
  template <typename Mark>
  void push(ImpulseResponse& response, linear::VertexField& v, const Mark& mark) {
    for (Push& each : pushes_) {
      const double impulse = std::max(0.0, each.impulse + each.mass * (each.target - each.speed_at(v)));
      const double change = impulse - each.impulse;
      if (change == 0.0) continue;
      each.impulse = impulse;
      response.push(each.vertices, each.weights, change * each.way, [&](mesh::VertexId of, const Eigen::Vector3d& by) {
        v.col(of) += by;
        mark(of);
      });
    }
  }

 private:
  // An impulse on an edge and on the triangle that it passes through, at the point that they share.
  struct Push {
    std::array<mesh::VertexId, 5> vertices{};  // two of the edge, three of the triangle
    std::array<double, 5> weights{};           // -, those of the edge sum to 1, the others to -1
    Eigen::Vector3d way{0.0, 0.0, 0.0};        // -, unit
    double mass = 0.0;                         // kg, effective
    double target = 0.0;                       // m/s
    double impulse = 0.0;                      // N s

    // Returns the speed (m/s) at which the edge leaves the triangle at velocities v, m/s.
    [[nodiscard]] double speed_at(const linear::VertexField& v) const {
      double sum = 0.0;
      for (std::size_t i = 0; i < vertices.size(); ++i) sum += weights[i] * way.dot(v.col(vertices[i]));
      return sum;
    }
  };

  void search(const linear::VertexField& x);
  void list_open(const SheetFeatures& features);

  std::vector<std::array<mesh::VertexId, 3>> triangles_;
  IntersectionSearch search_;
  bool is_known_ = false;
  linear::VertexField x_known_;                     // m, at which pairs_ pass through each other, if is_known_
  std::vector<std::array<std::int32_t, 2>> pairs_;  // of triangles
  ContourFinder contours_;
  std::vector<Piercing> piercings_;
  // Vertices that make a pair open with a vertex, ascending; by vertex id, and one more.
  std::vector<std::int32_t> first_open_;
  std::vector<mesh::VertexId> open_;
  std::vector<std::array<mesh::VertexId, 2>> open_pairs_;
  std::vector<Push> pushes_;
};

}  // namespace kerf::contact
