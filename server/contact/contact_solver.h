#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/contact/collider.h"
#include "server/mesh/vertex_field.h"

namespace kerf::contact {

// Counts since the solver was made; a scene without colliders leaves all of them at zero.
struct ContactCounters {
  std::int64_t phases = 0;    // calls of resolve() that had colliders to look at
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
class ContactSolver {
 public:
  // Passes over the colliders in one resolve(): the second repairs what the later colliders of the first undid.
  static constexpr int kPasses = 2;
  static constexpr int kNotchRounds = 16;
  static constexpr double kTouching = 1.0e-9;  // m; a penetration that is left to the next substep

  // Replaces the colliders, all of them valid. Allocates; resolve() does not.
  void set_colliders(std::span<const Collider> colliders);

  [[nodiscard]] bool empty() const { return colliders_.empty(); }

  // Moves the vertices in `x` (3 x V, m) and `v` (3 x V, m/s) out of all colliders.
  // `thickness`: m, >= 0; the distance at which a vertex is kept from a surface: half the sheet's thickness, so that
  // its lower face touches. `fixed`: V bytes, non-zero = leave that vertex alone (a pin); empty = none is. `x_before`:
  // 3 x V, m, where the vertices were when the substep began.
  void resolve(double thickness, std::span<const std::uint8_t> fixed, const mesh::VertexField& x_before,
               mesh::VertexField& x, mesh::VertexField& v);

  [[nodiscard]] std::span<const PreparedCollider> colliders() const { return colliders_; }
  [[nodiscard]] const ContactCounters& counters() const { return counters_; }

 private:
  // Moves a vertex that the passes left inside a collider out of the notch that keeps it there.
  void leave_notch(double thickness, Eigen::Vector3d& x, Eigen::Vector3d& v) const;
  struct Penetration {
    const PreparedCollider* collider = nullptr;
    double depth = 0.0;  // m
    Eigen::Vector3d normal{0.0, 0.0, 1.0};
  };
  // The deepest one beyond kTouching, the first of equals; no collider where there is none.
  [[nodiscard]] Penetration deepest(double thickness, const Eigen::Vector3d& x) const;
  // Whether a collider had to push the vertex.
  bool resolve_vertex(double thickness, const Eigen::Vector3d& x_before, Eigen::Vector3d& x, Eigen::Vector3d& v);

  std::vector<PreparedCollider> colliders_;
  ContactCounters counters_;
};

}  // namespace kerf::contact
