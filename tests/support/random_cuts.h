#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "server/base/random.h"
#include "server/core/cut/cut.h"
#include "server/core/fem/model/model.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::test {

// Returns a random cubic Bezier curve of about 0.3 m in a sheet of 1 m x 1 m.
inline cut::Curve random_cubic(SeededRandom& random) {
  const Eigen::Vector2d middle(random.uniform(0.1, 0.9), random.uniform(0.1, 0.9));
  const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
  const Eigen::Vector2d half = 0.15 * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  const auto nearby = [&] { return Eigen::Vector2d(random.uniform(-0.08, 0.08), random.uniform(-0.08, 0.08)); };
  const Eigen::Vector2d second = middle - half / 3.0 + nearby();
  const Eigen::Vector2d third = middle + half / 3.0 + nearby();
  return cut::CubicBezier{{middle - half, second, third, middle + half}};
}

// Makes random cuts on a mesh and its model, and can undo them.
class RandomCuts {
 public:
  RandomCuts(std::uint64_t seed, mesh::TriangleMesh& mesh, fem::Model& model)
      : random_(seed), mesh_(mesh), model_(model) {}

  // Makes cuts until there are `count` in all; curves that miss do not count.
  void make(std::size_t count) {
    while (done_.size() < count) make_one();
  }
  [[nodiscard]] std::size_t size() const { return done_.size(); }
  void make_one() {
    for (;;) {
      const Result<cut::CutPlan> planned = cut::plan(mesh_, {random_cubic(random_), {}, {}});
      if (!planned.ok()) continue;
      Result<cut::CutOutcome> done = cut::apply(mesh_, *planned);
      if (!done.ok() || done->status != cut::CutStatus::kApplied) continue;
      model_.apply(mesh_, done->edit);
      done_.push_back(std::move(*done));
      return;
    }
  }
  void undo_one() {
    done_.back().undo.undo(mesh_);
    std::vector<mesh::TriangleId> rewritten = done_.back().edit.rewritten_triangles;
    std::erase_if(rewritten, [&](mesh::TriangleId slot) { return slot >= mesh_.num_triangle_slots(); });
    std::sort(rewritten.begin(), rewritten.end());
    model_.follow(mesh_, rewritten);
    done_.pop_back();
  }

 private:
  SeededRandom random_;
  mesh::TriangleMesh& mesh_;
  fem::Model& model_;
  std::vector<cut::CutOutcome> done_;
};

}  // namespace kerf::test
