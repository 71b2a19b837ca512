#pragma once

#include <array>
#include <span>
#include <vector>

#include "server/core/fem/element/follower_loads.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/model.h"
#include "server/core/linear/block_matrix.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Factor (-) of the stiffness of each material: elastic + d beta. The second term is stiffness damping.
struct MaterialScale {
  double elastic = 1.0;          // -
  double d = 0.0;                // s
  std::span<const double> beta;  // s; see damping_of
  [[nodiscard]] double of(std::size_t material) const { return elastic + d * damping_of(beta, material); }
};

// The symmetric matrix of an implicit step, an equilibrium or a vibration: masses and stiffness of a model. It is
// assembled by calls of set_mass() and the add functions. Its pattern is kept between assemblies and follows cuts row
// by row.
class TangentMatrix {
 public:
  // Set the pattern for a model. rebuild() starts from nothing. follow() sets the changed rows after exactly one
  // Model::follow since the previous call.
  void rebuild(const Model& model);
  void follow(const Model& model);

  [[nodiscard]] linear::BlockMatrix& blocks() { return matrix_; }
  [[nodiscard]] const linear::BlockMatrix& blocks() const { return matrix_; }

  // Sets the matrix to the diagonal (inertia + d alpha) m, and 0 elsewhere. `inertia` is -, d is s, alpha the mass
  // damping and m the mass (kg) of a vertex. Vertices without material, which never move, get 1.
  void set_mass(const Model& model, double inertia, double d = 0.0);
  // Adds material_scale times the material and geometric_scale times the geometric stiffness of the membrane at x (3 x
  // V, m). See MembraneTangent::stiffness, also for `project`. `stress` (N/m, one a lane of the model's blocks)
  // replaces the stress at x unless it is empty.
  void add_membrane(const Model& model, const linear::VertexField& x, std::span<const Eigen::Vector3d> stress,
                    const MaterialScale& material_scale, double geometric_scale, bool project);
  // Adds scale times the stiffness of the quadratics that bound the membrane's energy from above at x (3 x V, m); see
  // MajorizedTriangle.
  void add_majorized_membrane(const Model& model, const linear::VertexField& x, double scale);
  void add_bending(const Model& model, const MaterialScale& scale);
  // Adds the stiffness of the model's bending at x (3 x V, m). If BendingOperator::bend_by_angles() is active, it is
  // that of the angles at the edges. For `moments` and `project` see AngleBending::add_stiffness.
  void add_bending_at(const Model& model, const linear::VertexField& x, std::span<const double> moments, bool project);
  // Adds d^2 stiffness + d damping of each grab.
  void add_grabs(std::span<const Grab> grabs, double d);

  // Adds scale times the symmetric or the skew part of the stiffness of pressure and edge moments at x (3 x V, m).
  // Neither part is positive semidefinite. With the skew part the matrix is no longer symmetric.
  void add_follower_loads(const Model& model, const Loads& loads, const linear::VertexField& x, double scale,
                          MatrixPart part);
  // Clears the rows and columns of components held by pins.
  void clear_pinned(std::span<const Pin> pins);

  // Imposes the pins `time_left` (s) before they reach their targets. Writes the displacements from x to their
  // positions into `step`, and adapts `rhs` (both 3 x V). Held components are decoupled: the matrix stays symmetric,
  // and positive definite if it was.
  void constrain(const Model& model, std::span<const Pin> pins, double time_left, const linear::VertexField& x,
                 linear::VertexField& rhs, linear::VertexField& step);

 private:
  using BlockPlaces = std::array<int, 9>;  // offset of corner pair (i, j), entry 3 i + j, from the beginning of row i

  void add_pressure(const Model& model, const Loads& loads, const linear::VertexField& x, double scale,
                    MatrixPart part);
  // Adds the damping of add_bending(), d beta times the stiffness, term by term, for materials with different beta.
  void add_bending_damping(const Model& model, const MaterialScale& scale);
  void find_columns(const Model& model, mesh::VertexId v);
  void set_rows(const Model& model, std::span<const mesh::VertexId> vertices);

  linear::BlockMatrix matrix_;
  std::vector<BlockPlaces> places_;  // one a lane of the model's blocks
  std::vector<int> columns_;         // scratch, of a row
};

}  // namespace kerf::fem
