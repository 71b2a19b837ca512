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

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

namespace kerf::contact {

// Counts since the solver was constructed. All stay zero without colliders.
struct ContactCounters {
  std::int64_t phases = 0;    // substeps in which vertices were checked
  std::int64_t blocks = 0;    // blocks of vertices checked, summed over these substeps
  std::int64_t contacts = 0;  // pushes of a vertex out of a collider
};

// Keeps vertices outside fixed colliders: unilateral contact with Coulomb friction, one vertex at a time.
//
// Let d < thickness be a vertex's signed distance from a collider with unit normal n (see Proximity), and u its motion
// since the substep began:
//   position   x += p n, p = thickness - d;  the tangential displacement u_t gets shorter by min(|u_t|, mu p)
//   velocity   if the vertex approaches (v . n < 0): v -= (v . n) n, an impulse per mass of J = -v . n;  the tangential
//              velocity v_t gets shorter by min(|v_t|, mu J)
// Both lines apply Coulomb's law of friction, with coefficient mu: the first to the motion of this substep, the second
// to the motion after it. See Mueller, Heidelberger, Hennix, Ratcliff 2007, sec. 3.4 and 3.6, and, for the impulse,
// Bridson, Fedkiw, Anderson 2002, sec. 7.3. With the second line alone, a sheet that sticks to an incline would creep
// down it, by its motion in each substep before friction acts. The correction of a position adds no velocity, so the
// removal of a penetration never creates energy.
//
// Each collider is treated in the given order, in kPasses passes. After two passes a vertex is outside both of two
// bodies that meet at a right angle or more. In a notch, a narrower corner between two bodies, each body pushes the
// vertex back into the other. There the vertex slides along the body it is deepest in, without friction, until it is
// outside the other. In a corner of three bodies and on curved bodies this is repeated; the result is approximate after
// kNotchRounds rounds. Between walls that leave no room the vertex stays inside one of them.
//
// Culling: the distance of a vertex from a collider changes by no more than the vertex moves. So a block of vertices is
// checked only when one of them may have travelled as far as the nearest collider was. The same rule decides for each
// collider within a block. No contact is missed.
//
// A vertex that is inside a collider when a step begins was put there by a scene, an undo or a cut. It leaves at
// kExitSpeed, because its neighbours cannot follow faster without being torn.
class ContactSolver {
 public:
  // Most passes over the colliders of a block. The second pass removes penetrations that the first has caused: by later
  // colliders, and by friction along curved ones.
  static constexpr int kPasses = 2;
  static constexpr int kNotchRounds = 16;
  static constexpr double kTouching = 1.0e-9;  // m; smaller penetrations are tolerated until the next substep
  static constexpr double kExitSpeed = 0.25;   // m/s; speed at which vertices that begin a step inside a collider leave
                                               // it

  // Replaces all colliders by `colliders`, which must be valid. Allocates memory.
  void set_colliders(std::span<const Collider> colliders);
  // Allocates memory for `num_vertices` vertices if there are colliders. begin() and later calls allocate none.
  void reserve(std::int32_t num_vertices);

  [[nodiscard]] bool empty() const { return colliders_.empty(); }
  [[nodiscard]] std::span<const PreparedCollider> colliders() const { return colliders_; }
  [[nodiscard]] const ContactCounters& counters() const { return counters_; }

  // Begins a step at positions `x`, 3 x V, m. `thickness` (m, >= 0) is the least distance of vertices from surfaces:
  // half the sheet's thickness, so that the face of the sheet touches. `fixed` has V bytes, non-zero for vertices to
  // leave alone (pins); empty means that no vertex is fixed.
  void begin(double thickness, std::span<const std::uint8_t> fixed, const linear::VertexField& x);
  // Returns the number of vertices that were deeper inside a collider than the sheet is thick when the step began.
  [[nodiscard]] int num_inside() const { return num_inside_; }
  // Returns the least distance of vertex v from surfaces at present, m; minus infinity if it is fixed. It is below
  // `thickness` of begin(), or negative, while v is still leaving a collider.
  [[nodiscard]] double thickness(std::size_t v) const;

  // Returns the blocks whose vertices may touch a collider, ascending. Call it once after each substep, of length `dt`
  // (s), in which no vertex moved farther than `travel` (m). The result is valid until the next call.
  std::span<const std::int32_t> find_due_blocks(double dt, double travel);
  // Moves the vertices of a block from find_due_blocks() out of all colliders. Returns a bit mask: bit l is set if
  // vertex l of the block was moved.
  std::uint32_t resolve(std::int32_t block, mesh::VertexLanes& vertices);
  // Finds and resolves the blocks that may touch a collider, after a substep of `dt` (s). `x_before`: positions at its
  // start, 3 x V, m. `x` (m) and `v` (m/s): positions and velocities at its end, which are corrected.
  void resolve(double dt, const linear::VertexField& x_before, linear::VertexField& x, linear::VertexField& v);

 private:
  friend struct Fields<ContactSolver>;
  struct Penetration {
    const PreparedCollider* collider = nullptr;
    double depth = 0.0;  // m
    Eigen::Vector3d normal{0.0, 0.0, 1.0};
  };

  [[nodiscard]] double& due(std::size_t collider, std::size_t block) { return due_[collider * num_blocks_ + block]; }
  // Sets due() of a collider for all blocks, from the positions `x` at the start of a step. Also lowers the starting
  // thickness of vertices that are inside the collider.
  void find_all_gaps(std::size_t collider, const linear::VertexField& x);
  void set_block_due(std::size_t block);
  // Makes one pass over the colliders and adds moved vertices to `pushed`. Returns true if a collider pushed a vertex
  // by more than kTouching.
  bool push_out_of_all(std::size_t block, const ThicknessLanes& thickness, mesh::VertexLanes& vertices,
                       std::uint32_t& pushed);
  // Moves a vertex that is still inside a collider after kPasses passes out of the notch that keeps it there. A notch
  // is a narrow corner of two colliders, each of which pushes the vertex back into the other.
  void leave_notch(double thickness, Eigen::Vector3d& x, Eigen::Vector3d& v) const;
  // Returns the deepest penetration of a vertex at x beyond kTouching, the first of equals. Its collider is null if
  // there is none.
  [[nodiscard]] Penetration deepest(double thickness, const Eigen::Vector3d& x) const;

  std::vector<PreparedCollider> colliders_;
  ContactCounters counters_;
  std::size_t num_blocks_ = 0;
  double thickness_ = 0.0;  // m
  double time_ = 0.0;       // s, since begin()
  double travel_ = 0.0;     // m, upper bound on the travel of any vertex since begin()
  int num_inside_ = 0;
  // m, for each block: least distances of its vertices from surfaces when the step began, below thickness_ for those
  // that were inside a collider.
  std::vector<ThicknessLanes> start_thickness_;
  std::vector<std::uint8_t> has_inside_;  // by block: 1 if a vertex was inside a collider when the step began
  // Travel (m) up to which no vertex touches. collider_due_: by collider, infinite once its blocks have their own
  // values. due_: by collider and block. block_due_: by block, the least over the colliders whose blocks have values.
  std::vector<double> collider_due_, due_, block_due_;
  std::vector<std::int32_t> due_blocks_;
  std::size_t last_pushing_ = 0;  // used by resolve(): the last collider that pushed a vertex of the block
  mesh::VertexLanes vertices_;    // used by resolve() and find_all_gaps()
};

}  // namespace kerf::contact
