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
// Normal: a penalty force N = k max(0, -gap) along the normal n of the surface. k is kStiffening times the resistance
// of the vertex's own inertia and membrane. ContactConstraint::enforce removes the remaining depth, N / k. Tangential:
// Coulomb's law by return mapping (Simo, Laursen 1992): -k u_t, cut off at mu N, with u_t the tangential displacement
// since the substep began. With one k for both, enforce() removes all of u_t exactly where the vertex sticks, so that
// sticking does not creep.
//
// Velocities: a stage of second order that ends on a surface would reflect what moved towards it, since its velocities
// follow from positions. stop() makes impacts inelastic instead, and what sticks rests.
//
// The displacement at which friction is cut off is tiny, so Newton's method would alternate between sticking and
// sliding. Hence its primal-dual form is used (Chan, Golub, Mulet 1999, for the similar law of total variation). The
// tangent uses the friction that the linear step before predicted, cut off at mu N; the force follows the law. The
// tangent is made symmetric, and is positive semidefinite as long as friction is within its limit. mu N is kept fixed
// in each Newton step, and follows the normal force from one to the next.
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

  enum class Update {
    kAdd,  // contacts found before stay, even where they pull; new ones are added, without friction at first
    // Contacts that would pull let go. Full Newton steps overshoot, so kAll after each of them would make contacts
    // chatter.
    kAll,
  };
  // Finds the contacts at `x` and their forces.
  void detect(const linear::VertexField& x, Update update);

  // Add scale * force to `forces` and scale * stiffness to `matrix`, for the contacts found last.
  void add_forces(double scale, linear::VertexField& forces) const;
  void add_stiffness(double scale, linear::BlockMatrix& matrix) const;
  // Takes from the velocities `v` (m/s) what a surface stops: all motion along its normal where it pushes, and all
  // along it where friction holds. The contacts are those found last.
  void stop(linear::VertexField& v) const;
  // Returns the potential of contact at `x`, J. Its negative gradient is the force that detect(x, kAll) finds, except
  // that limits of friction are those found last.
  [[nodiscard]] double potential(const linear::VertexField& x) const;

 private:
  struct Entry {
    int vertex = 0;
    bool sticks = false;
    SurfaceGap surface;
    double stiffness = 0.0;                   // N/m
    double limit = 0.0;                       // N, limit mu N of friction
    Eigen::Vector3d slid{0.0, 0.0, 0.0};      // m, tangential displacement u_t
    Eigen::Vector3d friction{0.0, 0.0, 0.0};  // N, as predicted by the linear step, within the limit
    Eigen::Vector3d force{0.0, 0.0, 0.0};     // N, by the law, normal and tangential
  };

  [[nodiscard]] double stiffness(int vertex) const;
  // Sets slid, sticks, friction and the tangential force of an entry that has slid by `slid`, m. `limit`: mu N, N. A
  // limit > 0 that the entry has already moves only half of the way there.
  static void update_friction(const Eigen::Vector3d& slid, double limit, Entry& entry);

  const ContactConstraint* contact_ = nullptr;
  const Model* model_ = nullptr;
  const linear::VertexField* start_ = nullptr;
  double inertia_ = 0.0;        // 1/s^2, 1 / d^2
  double membrane_ = 0.0;       // N/m
  std::vector<Entry> entries_;  // by vertex, then surface; both reserved for kMaxGaps a vertex
  std::vector<Entry> before_;   // entries_ of the previous detect() or predict()
};

}  // namespace kerf::fem
