#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "server/core/fem/element/state.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/vertex_lanes.h"

namespace kerf::fem {

class LocalInertia;

// A surface near a vertex.
struct SurfaceGap {
  int surface = 0;                        // number of the surface, the same until the scene changes
  double gap = 0.0;                       // m, distance left to the surface; < 0: past it
  Eigen::Vector3d normal{0.0, 0.0, 1.0};  // -, unit, the direction in which the gap grows fastest
  double friction = 0.0;                  // -, Coulomb's mu, >= 0
};

// Interface between an integrator and contact. `fem` and the module of contact do not know each other; the code that
// joins them implements it. No method may allocate. Once a substep, after positions and velocities were updated and
// pins set, vertices are moved out of surfaces they penetrate. The integrator calls enforce() for that, or
// find_due_blocks() and enforce_block().
class ContactConstraint {
 public:
  static constexpr std::size_t kMaxGaps = 3;  // per vertex: three fixed surfaces can stop all motion

  virtual ~ContactConstraint() = default;
  // Called before the first substep from positions `x`, m, and again when a step is discarded and restarted.
  virtual void begin(const linear::VertexField& x) = 0;
  // True if there are bodies. enforce() and find_gaps() need not be called without.
  [[nodiscard]] virtual bool has_bodies() const { return true; }
  // Number of vertices that were inside a body, deeper than the sheet is thick, in the last begin(). They are moved out
  // slowly.
  [[nodiscard]] virtual int num_inside() const = 0;
  // True if the sheet has rested on bodies for seconds, undisturbed and hardly moving. Friction must then hold it
  // still.
  [[nodiscard]] virtual bool is_calm() const { return false; }
  // Moves vertices out of surfaces after a substep of `dt`, s.
  virtual void enforce(double dt, State& state) = 0;
  // Finds the blocks of vertices that may touch a surface, ascending, after a substep of `dt`, s. No vertex moved
  // farther than `travel`, m, in that substep. The result is valid until the next call.
  virtual std::span<const std::int32_t> find_due_blocks(double dt, double travel) = 0;
  // Moves vertices of a block that find_due_blocks() returned. Returns a bit mask of the moved vertices: bit l is
  // vertex l of the block.
  virtual std::uint32_t enforce_block(std::int32_t block, mesh::VertexLanes& vertices) = 0;
  // Finds the surfaces whose gap to vertex `vertex`, if it were at `x` (m), is below `reach` (m, may be infinite). If
  // there are more than kMaxGaps, those with the smallest gaps are taken. Writes them to `gaps`, by ascending number of
  // the surface, and returns how many there are. A pinned vertex has none.
  virtual std::size_t find_gaps(int vertex, const Eigen::Vector3d& x, double reach,
                                std::array<SurfaceGap, kMaxGaps>& gaps) const = 0;

  // Contact of the sheet with itself, in phases between substeps. Returns true if the sheet has it.
  [[nodiscard]] virtual bool touches_itself() const { return false; }
  // Begins a step of `substeps` substeps of `h` (s) from `state`, before the first drift. `inverse_mass`: 1/kg, by
  // vertex, 0 for held ones; clusters of `inertia` move by theirs, and must not change before the next step. Changes
  // velocities of the vertices that it returns.
  virtual std::span<const mesh::VertexId> begin_self_contact(double /*h*/, int /*substeps*/,
                                                             const Eigen::Vector3d& /*gravity*/,
                                                             std::span<const double> /*inverse_mass*/,
                                                             const LocalInertia& /*inertia*/, State& /*state*/) {
    return {};
  }
  // Number of the substep after which the next phase is due; the last one is due after the last substep.
  [[nodiscard]] virtual int next_self_contact() const { return 0; }
  // Makes that phase. Changes `state` at the vertices that it returns.
  virtual std::span<const mesh::VertexId> make_self_contact(State& /*state*/) { return {}; }
  // Stops pairs that touch after the last phase from closing in, if velocities of `state` are not those of its drifts.
  virtual void end_self_contact(State& /*state*/) {}
};

}  // namespace kerf::fem
