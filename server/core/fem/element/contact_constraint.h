#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "server/core/fem/element/state.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/vertex_lanes.h"

namespace kerf::fem {

// A surface near a vertex.
struct SurfaceGap {
  int surface = 0;                        // which one, the same in every call between two changes of the scene
  double gap = 0.0;                       // m, what is left of the way to the surface; < 0: past it
  Eigen::Vector3d normal{0.0, 0.0, 1.0};  // -, unit, the direction in which the gap grows fastest
  double friction = 0.0;                  // -, Coulomb's mu, >= 0
};

// Contact as an integrator sees it; contact is a sibling module, so its owner bridges the two. Must not allocate.
// Once a substep, after positions and velocities were updated and pins set, vertices are moved out of what they
// penetrate: by enforce(), or by find_due_blocks() and enforce_block().
class ContactConstraint {
 public:
  static constexpr std::size_t kMaxGaps = 3;  // a vertex: as many fixed surfaces stop all its motion

  virtual ~ContactConstraint() = default;
  // Called before the first substep from positions `x`, m, and again when a step is thrown away and begun anew.
  virtual void begin(const mesh::VertexField& x) = 0;
  // Vertices that were inside a body, deeper than the sheet is thick, in the last begin(). They are brought out slowly.
  [[nodiscard]] virtual int num_inside() const = 0;
  // The sheet is on bodies, nothing has disturbed it for seconds, and it hardly moves: friction is to hold it.
  [[nodiscard]] virtual bool is_calm() const { return false; }
  // Moves all vertices, after a substep of `dt`, s.
  virtual void enforce(double dt, State& state) = 0;
  // Finds the blocks of vertices that may touch a surface, ascending, after a substep of `dt`, s, in which no vertex
  // moved farther than `travel`, m. They are valid until the next call.
  virtual std::span<const std::int32_t> find_due_blocks(double dt, double travel) = 0;
  // Moves vertices of one of these blocks. Returns which: bit l is vertex l of the block.
  virtual std::uint32_t enforce_block(std::int32_t block, mesh::VertexLanes& vertices) = 0;
  // The surfaces whose gap to vertex `vertex`, were it at `x` (m), is below `reach` (m, may be infinite), or the
  // kMaxGaps with the smallest gaps where there are more, into `gaps` by surface. Returns how many; none for a pin.
  virtual std::size_t find_gaps(int vertex, const Eigen::Vector3d& x, double reach,
                                std::array<SurfaceGap, kMaxGaps>& gaps) const = 0;
};

}  // namespace kerf::fem
