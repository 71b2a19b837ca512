#pragma once

#include <vector>

#include "server/core/fem/element/contact_constraint.h"
#include "server/core/fem/model/model.h"
#include "server/core/linear/block_matrix.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Contact among the forces of an implicit stage, so that what hangs from a vertex in contact is carried by the surface
// within the solve. Corrections after the solve alone would pull each such vertex back out, one by one, of where the
// weight of its neighbours took it, and leave the difference as strain.
//
// Normal: a penalty, k max(0, -gap) along n, with k kStiffening times what the vertex's own inertia and membrane resist
// with; the depth left, N / k, is taken back by ContactConstraint::enforce. Tangential: Coulomb's law by return mapping
// (Simo, Laursen 1992): -k u_t, cut off at mu N, for u_t the tangential displacement since the substep began. With one
// k for both, enforce() takes back the whole of u_t exactly where the vertex sticks, so that sticking does not creep.
//
// The cut-off is tiny, so Newton's method on it hops between sticking and sliding. Hence its primal-dual form (Chan,
// Golub, Mulet 1999, for the like law of total variation), with friction an unknown of its own in the tangent, not in
// the force: what the linear step predicted, cut to mu N. The tangent is that one made symmetric, positive semidefinite
// as long as friction is within its limit. mu N is a number that follows the normal force from step to step.
class StageContact {
 public:
  static constexpr double kStiffening = 100.0;

  // For a model of so many vertices. Allocates; the rest does not.
  void resize(int num_vertices);

  // Begins a stage of implicit weight d (s, see Stage). `contact` may be null: there is none then. `start`: 3 x V, m,
  // positions when the substep began; must outlive the stage.
  void begin(const ContactConstraint* contact, const Model& model, double d, const mesh::VertexField& start);

  // Whether a surface was found near any vertex.
  [[nodiscard]] bool touches() const { return !entries_.empty(); }

  // Before the first Newton step, where no contact force is known: finds the vertices that `step` (m) takes from `x`
  // into a surface and shortens it to end there, without sliding where friction can hold them. `impulse`: 3 x V, kg m,
  // d^2 times the forces at `x` and the momentum, which the surface would have to stop.
  void predict(const mesh::VertexField& x, const mesh::VertexField& impulse, mesh::VertexField& step);

  enum class Update {
    kAdd,  // contacts known stay, pulling where they should let go; new ones, as yet without friction, are added
    kAll,  // those that would pull let go: full Newton steps overshoot, and doing so at each would make them chatter
  };
  // Finds the contacts at `x` and their forces.
  void detect(const mesh::VertexField& x, Update update);

  // Of the contacts found last: scale * force added to `forces`, scale * stiffness to `matrix`.
  void add_forces(double scale, mesh::VertexField& forces) const;
  void add_stiffness(double scale, BlockMatrix& matrix) const;
  // J, at `x`: its negative gradient is the force there, with the friction limits of detect(kAll).
  [[nodiscard]] double potential(const mesh::VertexField& x) const;

 private:
  struct Entry {
    int vertex = 0;
    bool sticks = false;
    SurfaceGap surface;
    double stiffness = 0.0;                   // N/m
    double limit = 0.0;                       // N, mu N
    Eigen::Vector3d slid{0.0, 0.0, 0.0};      // m, u_t
    Eigen::Vector3d friction{0.0, 0.0, 0.0};  // N, as the linear step predicted it, within the limit
    Eigen::Vector3d force{0.0, 0.0, 0.0};     // N, as the law says
  };

  [[nodiscard]] double stiffness(int vertex) const;
  // Where the entry has slid by `slid`, m, and its friction would be cut off at `limit`, N.
  static void update_friction(const Eigen::Vector3d& slid, double limit, Entry& entry);

  const ContactConstraint* contact_ = nullptr;
  const Model* model_ = nullptr;
  const mesh::VertexField* start_ = nullptr;
  double inertia_ = 0.0;        // 1/s^2, 1 / d^2
  double membrane_ = 0.0;       // N/m
  std::vector<Entry> entries_;  // by vertex, then surface; both reserved for kMaxGaps a vertex
  std::vector<Entry> before_;   // those of the call before
};

}  // namespace kerf::fem
