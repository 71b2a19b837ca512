#pragma once

#include <vector>

#include "server/core/fem/element/contact_constraint.h"
#include "server/core/fem/model/model.h"
#include "server/core/linear/block_matrix.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Contact forces within an implicit stage (see Stage). With them the surface carries the weight on a vertex in contact
// while the stage is solved. Without them the weight of the neighbours would pull such a vertex into the surface. A
// correction after the solve would move only this vertex back, and leave its displacement as strain.
//
// Normal: a force N along the normal n of the surface, unknown beside the positions. A linear step finds it as
// N - k (gap + n . dx), where k is kStiffening times the resistance of the vertex's own inertia and membrane. Each step
// leaves a hundredth of the gap that it began with, and none of it counts as force. project() removes the rest.
// Tangential: Coulomb's law by return mapping (Simo, Laursen 1992): -k u_t, cut off at mu N, with u_t the tangential
// displacement since the substep began. project() removes all of u_t where the vertex sticks, so that sticking does not
// creep.
//
// Velocities: a stage of second order that ends on a surface would reflect what moved towards it, since its velocities
// follow from positions. stop() makes impacts inelastic instead, and what sticks rests.
//
// The displacement at which friction is cut off is tiny, so Newton's method would alternate between sticking and
// sliding. Two things prevent that:
//  - The primal-dual form (Chan, Golub, Mulet 1999, for the similar law of total variation). The tangent uses the
//    friction that the linear step before predicted, cut off at mu N; the force follows the law. The tangent is made
//    symmetric, and is positive semidefinite as long as friction is within its limit. mu N is kept fixed in each Newton
//    step, and follows the normal force from one to the next.
//  - share_without_overshoot() shortens steps that go past the least potential along them. With mu N fixed that
//    potential is convex.
//
// Repairs minimise a potential instead, see begin_penalty().
class StageContact {
 public:
  static constexpr double kStiffening = 100.0;

  // Sizes the object for a model of `num_vertices` vertices. Allocates; all other calls do not.
  void resize(int num_vertices);

  // Begins a stage of implicit weight d (s, see Stage). A null `contact` means no contact. `start` (3 x V, m) holds the
  // positions when the substep began and must outlive the stage.
  void begin(const ContactConstraint* contact, const Model& model, double d, const linear::VertexField& start);

  // Returns true if a surface was found near any vertex.
  [[nodiscard]] bool touches() const { return !entries_.empty(); }

  // Predicts contacts before the first Newton step, when no contact force is known. Finds the vertices that `step` (m)
  // takes from `x` into a surface. Shortens their steps to end at the surface, without sliding where friction can hold
  // them. `impulse` (3 x V, kg m) is d^2 times the forces at `x`, plus d times the momentum that the surface would have
  // to stop.
  void predict(const linear::VertexField& x, const linear::VertexField& impulse, linear::VertexField& step);

  // Makes N = k max(0, -gap) from now on, which has a potential, but is too small by up to 1 / kStiffening. Forgets all
  // contacts. mu N then follows N halfway from one step to the next.
  void begin_penalty();

  // Finds the contacts at `x` (m) and their forces. Those found before stay, even where they pull. New ones have no
  // force at first. Forces of penalties follow from `x` alone, and contacts that would pull let go.
  void detect(const linear::VertexField& x);
  // Lets go of contacts that pull, and takes scale * their force from `forces`. Newton steps overshoot, so doing that
  // after each of them would make contacts chatter.
  void release(double scale, linear::VertexField& forces);
  // Sets N to the values that the linear system found with the step that a Newton step makes. `step` (m): the solution
  // of the system, times `share` (-, (0, 1]) if the step was shortened.
  void follow(const linear::VertexField& step, double share);
  // Returns the share of `step` (m), at most 1, at which its slope vanishes, or 1 if the step hardly goes beyond. The
  // slope is that of minus the potential, without contact `before` at its start and `after` at its end, linear between
  // them; scale * the contact forces is added.
  [[nodiscard]] double share_without_overshoot(const linear::VertexField& step, double scale, double before,
                                               double after) const;
  // Moves vertices of `x` (m) that a surface pushes onto it, and those that stick back to where they were.
  void project(linear::VertexField& x);

  // Add scale * force to `forces` and scale * stiffness to `matrix`, for the contacts found last.
  void add_forces(double scale, linear::VertexField& forces) const;
  void add_stiffness(double scale, linear::BlockMatrix& matrix) const;
  // Adds scale * (-k gap n), with which the next linear step closes the gaps. Penalties have it in their force.
  void add_gap_forces(double scale, linear::VertexField& forces) const;
  // Norms over the contacts found last, N: of N, of mu N, and of the forces by which the sheet resists closing the
  // gaps.
  [[nodiscard]] double normal_norm() const;
  [[nodiscard]] double friction_norm() const;
  [[nodiscard]] double gap_norm() const;
  // Returns the work of the contact forces along `step` (m), J.
  [[nodiscard]] double work(const linear::VertexField& step) const;
  // Takes from the velocities `v` (m/s) what a surface stops: all motion along its normal where it pushes, and all
  // along it where friction holds. The contacts are those found last.
  void stop(linear::VertexField& v) const;
  // Returns the potential of contact at `x`, J. Its negative gradient is the force that detect(x) finds with
  // penalties, except that limits of friction are those found last.
  [[nodiscard]] double potential(const linear::VertexField& x) const;

 private:
  struct Entry {
    int vertex = 0;
    bool sticks = false;
    SurfaceGap surface;
    double stiffness = 0.0;                   // N/m
    double normal = 0.0;                      // N, normal force N; < 0 where the contact pulls
    double limit = 0.0;                       // N, limit mu N of friction
    Eigen::Vector3d slid{0.0, 0.0, 0.0};      // m, tangential displacement u_t
    Eigen::Vector3d friction{0.0, 0.0, 0.0};  // N, as predicted by the linear step, within the limit
    Eigen::Vector3d force{0.0, 0.0, 0.0};     // N, by the law, normal and tangential
  };

  [[nodiscard]] double stiffness(int vertex) const;
  // Sets slid, sticks, limit, friction and the tangential force of an entry that has slid by `slid`, m. `limit`: mu N,
  // N.
  static void update_friction(const Eigen::Vector3d& slid, double limit, Entry& entry);
  // Returns the work per length of the contact forces after a share of `step`, J, for N that the linear system finds.
  [[nodiscard]] double slope(const linear::VertexField& step, double share) const;

  const ContactConstraint* contact_ = nullptr;
  const Model* model_ = nullptr;
  const linear::VertexField* start_ = nullptr;
  double inertia_ = 0.0;   // 1/s^2, 1 / d^2
  double membrane_ = 0.0;  // N/m
  bool is_penalty_ = false;
  std::vector<Entry> entries_;  // by vertex, then surface; both reserved for kMaxGaps a vertex
  std::vector<Entry> before_;   // entries_ of the previous detect() or predict()
};

}  // namespace kerf::fem
