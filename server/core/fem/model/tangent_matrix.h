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

// Factor (-) applied to the stiffness of a material: elastic + d beta; the second term is damping.
struct MaterialScale {
  double elastic = 1.0;          // -
  double d = 0.0;                // s
  std::span<const double> beta;  // s; see damping_of
  [[nodiscard]] double of(std::size_t material) const { return elastic + d * damping_of(beta, material); }
};

// The symmetric matrix of an implicit step, an equilibrium or a vibration: masses and stiffness of a model. It is
// assembled from parts in a pattern that is kept between assemblies and follows cuts row by row.
class TangentMatrix {
 public:
  // Sets the pattern for a model: rebuild() from nothing, follow() after exactly one Model::follow, changed rows only.
  void rebuild(const Model& model);
  void follow(const Model& model);

  [[nodiscard]] BlockMatrix& blocks() { return matrix_; }
  [[nodiscard]] const BlockMatrix& blocks() const { return matrix_; }

  // Sets the matrix to the diagonal (inertia + d alpha) m, and 0 elsewhere. `inertia` is -, d is s, alpha the mass
  // damping and m the mass (kg) of a vertex. Vertices without material, which never move, get 1.
  void set_mass(const Model& model, double inertia, double d = 0.0);
  // Adds material_scale times the material and geometric_scale times the geometric stiffness of the membrane at x (3 x
  // V, m). See MembraneTangent::stiffness, also for `project`. `stress` (N/m, one a lane of the model's blocks)
  // replaces the stress at x unless it is empty.
  void add_membrane(const Model& model, const mesh::VertexField& x, std::span<const Eigen::Vector3d> stress,
                    const MaterialScale& material_scale, double geometric_scale, bool project);
  // Adds scale times the stiffness of the quadratics that bound the membrane's energy from above at x (3 x V, m); see
  // MajorizedTriangle.
  void add_majorized_membrane(const Model& model, const mesh::VertexField& x, double scale);
  void add_bending(const Model& model, const MaterialScale& scale);
  // Adds the stiffness of the model's bending at x (3 x V, m). If BendingOperator::bend_by_angles() is active, it is
  // that of the angles at the edges. For `moments` and `project` see AngleBending::add_stiffness.
  void add_bending_at(const Model& model, const mesh::VertexField& x, std::span<const double> moments, bool project);
  // Adds the springs and dampers of grabs, d^2 stiffness + d damping.
  void add_grabs(std::span<const Grab> grabs, double d);

  // Adds scale times a part of the stiffness of pressure and moments at x (3 x V, m). Neither part is positive
  // semidefinite. With the skew part the matrix is no longer symmetric.
  void add_follower_loads(const Model& model, const Loads& loads, const mesh::VertexField& x, double scale,
                          MatrixPart part);
  // Clears the rows and columns of components held by pins.
  void clear_pinned(std::span<const Pin> pins);

  // Imposes the pins: writes the displacement from x to their positions, `time_left` (s) before they reach their
  // targets, into `step` and `rhs` (3 x V). It decouples the held components: the matrix stays symmetric, and positive
  // definite where it was.
  void constrain(const Model& model, std::span<const Pin> pins, double time_left, const mesh::VertexField& x,
                 mesh::VertexField& rhs, mesh::VertexField& step);

 private:
  using BlockPlaces = std::array<int, 9>;  // offset of corner pair (i, j), entry 3 i + j, from the beginning of row i

  void add_pressure(const Model& model, const Loads& loads, const mesh::VertexField& x, double scale, MatrixPart part);
  // Adds the damping part of add_bending, which scale.elastic times the stiffness does not have, patch by patch.
  void add_bending_damping(const Model& model, const MaterialScale& scale);
  void find_columns(const Model& model, mesh::VertexId v);
  void set_rows(const Model& model, std::span<const mesh::VertexId> vertices);

  BlockMatrix matrix_;
  std::vector<BlockPlaces> places_;  // one a lane of the model's blocks
  std::vector<int> columns_;         // scratch, of a row
};

}  // namespace kerf::fem
