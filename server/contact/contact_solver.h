#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/contact/collider.h"

namespace kerf::contact {

// Counts since the solver was made; a scene without colliders leaves all of them at zero.
struct ContactCounters {
  std::int64_t phases = 0;    // calls of resolve() that had colliders to look at
  std::int64_t contacts = 0;  // (vertex, collider) pairs that were pushed out
};

// Keeps vertices outside fixed colliders: unilateral contact with Coulomb friction, one vertex at a time.
//
// For a vertex at signed distance d < thickness from a collider with unit normal n (see Proximity):
//   position   x += (thickness - d) n
//   velocity   v_n = v . n; an approaching vertex (v_n < 0) loses it: impulse per mass J = -v_n;
//              the tangential velocity v_t loses min(|v_t|, mu * J)                            (Coulomb's cone)
// The projection adds no velocity: what a step of length dt moved a vertex through the surface is taken back without
// becoming energy. Followed for each collider in the given order, twice over, so that a vertex in the notch between two
// bodies ends outside both (Bridson, Fedkiw, Anderson 2002, sec. 7.3, uses the same impulse with friction).
class ContactSolver {
 public:
  // Passes over the colliders in one resolve(): the second repairs what the later colliders of the first undid.
  static constexpr int kPasses = 2;

  // Replaces the colliders, all of them valid. Allocates; resolve() does not.
  void set_colliders(std::span<const Collider> colliders);

  [[nodiscard]] bool empty() const { return colliders_.empty(); }

  // Moves the vertices in `x` (3 x V, m) and `v` (3 x V, m/s) out of all colliders.
  // `thickness`: m, >= 0; the distance at which a vertex is kept from a surface: half the sheet's thickness, so that
  // its lower face touches. `fixed`: V bytes, non-zero = leave that vertex alone (a pin); empty = none is.
  void resolve(double thickness, std::span<const std::uint8_t> fixed, Eigen::Ref<Eigen::Matrix3Xd> x,
               Eigen::Ref<Eigen::Matrix3Xd> v);

  [[nodiscard]] const ContactCounters& counters() const { return counters_; }

 private:
  std::vector<PreparedCollider> colliders_;
  ContactCounters counters_;
};

}  // namespace kerf::contact
