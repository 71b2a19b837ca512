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

// Counts since the solver was made; a scene without colliders leaves all of them at zero.
struct ContactCounters {
  std::int64_t phases = 0;    // substeps in which vertices were looked at
  std::int64_t blocks = 0;    // of vertices that were looked at, of all phases
  std::int64_t contacts = 0;  // times a vertex was pushed out of a collider
};

// Keeps vertices outside fixed colliders: unilateral contact with Coulomb friction, one vertex at a time.
//
// For a vertex at signed distance d < thickness from a collider with unit normal n (see Proximity), which moved by u
// since the substep began:
//   position   x += p n, p = thickness - d;  the tangential displacement u_t loses min(|u_t|, mu p)
//   velocity   an approaching vertex (v . n < 0) loses v . n: impulse per mass J = -v . n; the tangential velocity v_t
//              loses min(|v_t|, mu J)
// Both lines are Coulomb's cone, once for the motion that was done and once for the motion to come (Mueller,
// Heidelberger, Hennix, Ratcliff 2007, sec. 3.4 and 3.6; Bridson, Fedkiw, Anderson 2002, sec. 7.3, for the impulse):
// with the second alone a sheet that sticks would creep down an incline by what it moved before friction was asked. The
// correction of a position adds no velocity, so that taking back a penetration is never turned into energy. Done for
// each collider in the given order, twice over. That ends outside both of two bodies that meet at a right angle or
// more; in a narrower notch each pushes the vertex back into the other, so there it is slid along the one it is deepest
// in until it is outside the other, without friction. In a corner of three and on curved bodies that is repeated, and
// approximate once kNotchRounds are used up; between walls that leave no room it stays in one of them.
//
// Bounds: distances change by no more than vertices move. A block of vertices is looked at where one of them may have
// travelled as far as the nearest collider was, a collider where it was as near. Nothing that touches is missed.
//
// A vertex that is inside a collider as the step begins was put there by a scene, an undo or a cut: it is brought out
// at kExitSpeed, as its neighbours cannot follow faster without being torn.
class ContactSolver {
 public:
  // Passes over the colliders of a block: the second repairs what later colliders and friction along curved
  // ones undid in the first.
  static constexpr int kPasses = 2;
  static constexpr int kNotchRounds = 16;
  static constexpr double kTouching = 1.0e-9;  // m; a penetration that is left to the next substep
  static constexpr double kExitSpeed = 0.25;   // m/s

  // Replaces the colliders, all of them valid. Allocates.
  void set_colliders(std::span<const Collider> colliders);
  // Makes room for so many vertices, where there are colliders. Allocates; what follows does not.
  void reserve(std::int32_t num_vertices);

  [[nodiscard]] bool empty() const { return colliders_.empty(); }
  [[nodiscard]] std::span<const PreparedCollider> colliders() const { return colliders_; }
  [[nodiscard]] const ContactCounters& counters() const { return counters_; }

  // Begins a step at positions `x`, 3 x V, m. `thickness`: m, >= 0; the distance at which a vertex is kept from a
  // surface: half the sheet's thickness, so that its lower face touches. `fixed`: V bytes, non-zero = leave that vertex
  // alone (a pin); empty = none is.
  void begin(double thickness, std::span<const std::uint8_t> fixed, const mesh::VertexField& x);
  // Vertices that are deeper inside a collider than the sheet is thick, as the step began.
  [[nodiscard]] int num_inside() const { return num_inside_; }
  // m, what is kept from a surface at vertex v now; minus infinity where it is fixed.
  [[nodiscard]] double thickness(std::size_t v) const;

  // After a substep of `dt`, s, in which no vertex moved farther than `travel`, m: the blocks that may touch,
  // ascending; valid until the next call.
  std::span<const std::int32_t> find_due_blocks(double dt, double travel);
  // Moves vertices of a due block out of all colliders. Returns which: bit l is vertex l of the block.
  std::uint32_t resolve(std::int32_t block, mesh::VertexLanes& vertices);
  // The same of all due blocks, for vertices that were at `x_before`, 3 x V, m, when the substep of `dt`, s, began.
  void resolve(double dt, const mesh::VertexField& x_before, mesh::VertexField& x, mesh::VertexField& v);

 private:
  struct Penetration {
    const PreparedCollider* collider = nullptr;
    double depth = 0.0;  // m
    Eigen::Vector3d normal{0.0, 0.0, 1.0};
  };

  [[nodiscard]] double& due(std::size_t collider, std::size_t block) { return due_[collider * num_blocks_ + block]; }
  // Sets due() of a collider at the present travel from all blocks of `x`, and what they are kept at that are inside.
  void look_at_all(std::size_t collider, const mesh::VertexField& x);
  void set_block_due(std::size_t block);
  // One pass over the colliders; adds to `pushed`, returns whether one pushed by more than kTouching.
  bool push_out_of_all(std::size_t block, const ThicknessLanes& thickness, mesh::VertexLanes& vertices,
                       std::uint32_t& pushed);
  // Moves a vertex that the passes left inside a collider out of the notch that keeps it there.
  void leave_notch(double thickness, Eigen::Vector3d& x, Eigen::Vector3d& v) const;
  // The deepest one beyond kTouching, the first of equals; no collider where there is none.
  [[nodiscard]] Penetration deepest(double thickness, const Eigen::Vector3d& x) const;

  std::vector<PreparedCollider> colliders_;
  ContactCounters counters_;
  std::size_t num_blocks_ = 0;
  double thickness_ = 0.0;  // m
  double time_ = 0.0;       // s, since begin()
  double travel_ = 0.0;     // m, of the fastest vertex since begin()
  int num_inside_ = 0;
  // m, one a block: what vertices were kept at when the step began, less than thickness_ where they were inside.
  std::vector<ThicknessLanes> start_thickness_;
  std::vector<std::uint8_t> has_inside_;  // of each block
  // Travel, m, up to which nothing touches: of a whole collider, infinite once its blocks have their own; of a collider
  // and a block; of a block and the colliders that are not whole.
  std::vector<double> collider_due_, due_, block_due_;
  std::vector<std::int32_t> due_blocks_;
  std::size_t last_pushing_ = 0;  // scratch of resolve(): nothing moved the block since that collider pushed it
  mesh::VertexLanes vertices_;    // scratch
};

}  // namespace kerf::contact
