#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/contact/shared_inertia.h"
#include "server/core/fem/model/local_inertia.h"
#include "server/core/linear/lanes16.h"
#include "server/core/mesh/ids.h"

namespace kerf::sheet {

// Shows clusters of tiny triangles to contact of a sheet with itself, since fem and contact may not include each other.
class ClusterInertia : public contact::SharedInertia {
 public:
  // Must be called before each step; `inertia` must outlive it.
  void set(const fem::LocalInertia& inertia) { inertia_ = &inertia; }

  [[nodiscard]] std::size_t num_groups() const override { return inertia_->clusters().size(); }
  [[nodiscard]] std::span<const mesh::VertexId> vertices(std::size_t group) const override {
    return inertia_->clusters()[group]->vertices();
  }
  void respond(std::size_t group, std::size_t place, std::span<Eigen::Array3d> velocities) const override;

 private:
  const fem::LocalInertia* inertia_ = nullptr;
  mutable std::vector<linear::Lanes16<double>> values_;  // N s, then m/s; four a vertex
};

}  // namespace kerf::sheet
