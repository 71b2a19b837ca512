#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/fem/model.h"
#include "server/mesh/ids.h"

namespace kerf::fem {

// Counts the vertices whose row of the stiffness sums to more than a limit times their mass: those that an explicit
// step longer than 2 / sqrt(limit) wants in clusters. The count follows from the model and the limit alone.
class StiffVertices {
 public:
  void rebuild(const Model& model, double limit);  // limit: 1/s^2
  // After one Model::follow since the call before.
  void follow(const Model& model, double limit);
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  // `changed` may repeat.
  void update(const Model& model, std::span<const mesh::VertexId> changed);

  double limit_ = 0.0;                  // 1/s^2
  std::vector<std::uint8_t> is_stiff_;  // length V
  std::size_t count_ = 0;
};

}  // namespace kerf::fem
