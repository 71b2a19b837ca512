#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "server/core/fem/element/contact_constraint.h"

namespace kerf::fem {

// Touches nothing.
class NoContact final : public ContactConstraint {
 public:
  explicit NoContact(bool is_calm = false) : is_calm_(is_calm) {}
  void begin(const linear::VertexField& /*x*/) override {}
  [[nodiscard]] int num_inside() const override { return 0; }
  [[nodiscard]] bool is_calm() const override { return is_calm_; }
  void enforce(double /*dt*/, State& /*state*/) override {}
  std::span<const std::int32_t> find_due_blocks(double /*dt*/, double /*travel*/) override { return {}; }
  std::uint32_t enforce_block(std::int32_t /*block*/, mesh::VertexLanes& /*vertices*/) override { return 0; }
  std::size_t find_gaps(int /*vertex*/, const Eigen::Vector3d& /*x*/, double /*reach*/,
                        std::array<SurfaceGap, kMaxGaps>& /*gaps*/) const override {
    return 0;
  }

 private:
  bool is_calm_;
};

}  // namespace kerf::fem
