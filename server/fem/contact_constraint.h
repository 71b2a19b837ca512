#pragma once

#include <array>

#include <Eigen/Core>

#include "server/fem/state.h"
#include "server/mesh/vertex_field.h"

namespace kerf::fem {

// A surface near a vertex.
struct SurfaceGap {
  int surface = 0;                        // which one, the same in every call between two changes of the scene
  double gap = 0.0;                       // m, what is left of the way to the surface; < 0: past it
  Eigen::Vector3d normal{0.0, 0.0, 1.0};  // -, unit, the direction in which the gap grows fastest
  double friction = 0.0;                  // -, Coulomb's mu, >= 0
};

// Contact as an integrator sees it; contact is a sibling module, so its owner bridges the two. Must not allocate.
class ContactConstraint {
 public:
  static constexpr std::size_t kMaxGaps = 3;  // a vertex: as many fixed surfaces stop all its motion

  virtual ~ContactConstraint() = default;
  // Called before the first substep from positions `x`, m, and again when a step is thrown away and begun anew.
  virtual void begin(const mesh::VertexField& x) = 0;
  // Called once a substep, after positions and velocities were updated and pins set: moves them out of what they
  // penetrate. dt: the substep, s.
  virtual void enforce(double dt, State& state) = 0;
  // The surfaces whose gap to vertex `vertex`, were it at `x` (m), is below `reach` (m, may be infinite), or the
  // kMaxGaps with the smallest gaps where there are more, into `gaps` by surface. Returns how many; none for a pin.
  virtual std::size_t find_gaps(int vertex, const Eigen::Vector3d& x, double reach,
                                std::array<SurfaceGap, kMaxGaps>& gaps) const = 0;
};

}  // namespace kerf::fem
