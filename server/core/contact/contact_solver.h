#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/contact/collider.h"
#include "server/core/contact/lane_contact.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/vertex_lanes.h"

namespace kerf::contact {

// Counts since the solver was made. All stay zero in a scene without colliders.
struct ContactCounters {
  std::int64_t phases = 0;    // substeps in which vertices were checked
  std::int64_t blocks = 0;    // blocks of vertices checked, over all phases
  std::int64_t contacts = 0;  // times a vertex was pushed out of a collider
};

// Keeps vertices outside fixed colliders: unilateral contact with Coulomb friction, one vertex at a time.
//
// Let d < thickness be a vertex's signed distance from a collider with unit normal n (see Proximity), and u its motion
// since the substep began:
//   position   x += p n, p = thickness - d;  the tangential displacement u_t loses min(|u_t|, mu p)
//   velocity   an approaching vertex (v . n < 0) loses v . n: impulse per mass J = -v . n; the tangential velocity v_t
//              loses min(|v_t|, mu J)
// Both lines apply Coulomb's cone: the first to the motion of this substep, the second to the motion to come. See
// Mueller, Heidelberger, Hennix, Ratcliff 2007, sec. 3.4 and 3.6, and, for the impulse, Bridson, Fedkiw, Anderson 2002,
// sec. 7.3. With the second line alone, a sheet that sticks would creep down an incline by its motion before friction
// acts. The correction of a position adds no velocity, so that removing a penetration never creates energy.
//
// Each collider is treated in the given order, in kPasses passes. Two passes end outside both of two bodies that meet
// at a right angle or more. In a narrower notch each body pushes the vertex back into the other. There the vertex
// slides, without friction, along the body it is deepest in until it is outside the other. In a corner of three bodies
// and on curved bodies this is repeated, and is approximate once kNotchRounds are used up. Between walls that leave no
// room the vertex stays in one of them.
//
// Culling: a distance changes by no more than the vertex moves. A block of vertices is checked once one of them may
// have travelled as far as the nearest collider was. Within a block, each collider is treated by the same rule. No
// contact is missed.
//
// A vertex that is inside a collider as a step begins was put there by a scene, an undo or a cut. It leaves at
// kExitSpeed, because its neighbours cannot follow faster without being torn.
class ContactSolver {
 public:
  // Passes over the colliders of a block. The second repairs errors that later colliders and friction along curved ones
  // caused in the first.
  static constexpr int kPasses = 2;
  static constexpr int kNotchRounds = 16;
  static constexpr double kTouching = 1.0e-9;  // m; a smaller penetration is left to the next substep
  static constexpr double kExitSpeed = 0.25;   // m/s

  // Replaces the colliders, all of them valid. Allocates.
  void set_colliders(std::span<const Collider> colliders);
  // Makes room for `num_vertices` vertices if there are colliders. Allocates; begin() and later calls do not.
  void reserve(std::int32_t num_vertices);

  [[nodiscard]] bool empty() const { return colliders_.empty(); }
  [[nodiscard]] std::span<const PreparedCollider> colliders() const { return colliders_; }
  [[nodiscard]] const ContactCounters& counters() const { return counters_; }

  // Begins a step at positions `x`, 3 x V, m. `thickness` (m, >= 0) is the distance at which vertices are kept from
  // surfaces: half the sheet's thickness, so that its lower face touches. `fixed` has V bytes, non-zero for vertices to
  // leave alone (pins); empty means no vertex is fixed.
  void begin(double thickness, std::span<const std::uint8_t> fixed, const mesh::VertexField& x);
  // Number of vertices that were deeper inside a collider than the sheet is thick when the step began.
  [[nodiscard]] int num_inside() const { return num_inside_; }
  // m; distance at which vertex v is kept from surfaces now, or minus infinity if it is fixed.
  [[nodiscard]] double thickness(std::size_t v) const;

  // Returns the blocks that may touch, ascending, after a substep of `dt` (s) in which no vertex moved farther than
  // `travel` (m). The result is valid until the next call.
  std::span<const std::int32_t> find_due_blocks(double dt, double travel);
  // Moves vertices of a due block out of all colliders. Returns a bit mask of the moved ones: bit l is vertex l of the
  // block.
  std::uint32_t resolve(std::int32_t block, mesh::VertexLanes& vertices);
  // Resolves all due blocks, for vertices that were at `x_before` (3 x V, m) when the substep of `dt` (s) began.
  void resolve(double dt, const mesh::VertexField& x_before, mesh::VertexField& x, mesh::VertexField& v);

 private:
  struct Penetration {
    const PreparedCollider* collider = nullptr;
    double depth = 0.0;  // m
    Eigen::Vector3d normal{0.0, 0.0, 1.0};
  };

  [[nodiscard]] double& due(std::size_t collider, std::size_t block) { return due_[collider * num_blocks_ + block]; }
  // Sets due() of a collider at the present travel from all blocks of `x`. Also sets the starting thickness of vertices
  // that are inside it.
  void find_all_gaps(std::size_t collider, const mesh::VertexField& x);
  void set_block_due(std::size_t block);
  // Makes one pass over the colliders and adds moved vertices to `pushed`. Returns true if a collider pushed by more
  // than kTouching.
  bool push_out_of_all(std::size_t block, const ThicknessLanes& thickness, mesh::VertexLanes& vertices,
                       std::uint32_t& pushed);
  // Moves a vertex that is still inside a collider after kPasses passes out of the notch that keeps it there. A notch
  // is a narrow corner of two colliders, each of which pushes the vertex back into the other.
  void leave_notch(double thickness, Eigen::Vector3d& x, Eigen::Vector3d& v) const;
  // Returns the deepest penetration beyond kTouching, the first of equals, or one without a collider.
  [[nodiscard]] Penetration deepest(double thickness, const Eigen::Vector3d& x) const;

  std::vector<PreparedCollider> colliders_;
  ContactCounters counters_;
  std::size_t num_blocks_ = 0;
  double thickness_ = 0.0;  // m
  double time_ = 0.0;       // s, since begin()
  double travel_ = 0.0;     // m, of the fastest vertex since begin()
  int num_inside_ = 0;
  // m, one a block: distances at which vertices were kept when the step began, below thickness_ where they were inside.
  std::vector<ThicknessLanes> start_thickness_;
  std::vector<std::uint8_t> has_inside_;  // by block
  // Travel (m) up to which nothing touches: by collider, infinite once its blocks have their own values; by collider
  // and block; by block, over the colliders that have values by block.
  std::vector<double> collider_due_, due_, block_due_;
  std::vector<std::int32_t> due_blocks_;
  std::size_t last_pushing_ = 0;  // scratch of resolve(): last collider that pushed the block
  mesh::VertexLanes vertices_;    // scratch
};

}  // namespace kerf::contact
