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

// How often the stiffness of a material counts, -: elastic + d beta, the latter for damping.
struct MaterialScale {
  double elastic = 1.0;          // -
  double d = 0.0;                // s
  std::span<const double> beta;  // s; see damping_of
  [[nodiscard]] double of(std::size_t material) const { return elastic + d * damping_of(beta, material); }
};

// The symmetric matrix of an implicit step, an equilibrium or a vibration: masses and stiffness of a model, put
// together from parts in a pattern that is kept from one assembly to the next and follows cuts row by row.
class TangentMatrix {
 public:
  // Of the model, from nothing, or after one Model::follow: only the rows that changed.
  void rebuild(const Model& model);
  void follow(const Model& model);

  [[nodiscard]] BlockMatrix& blocks() { return matrix_; }
  [[nodiscard]] const BlockMatrix& blocks() const { return matrix_; }

  // Everything 0 but the diagonal: inertia (-) + d (s) alpha times the masses, kg, alpha being the damping of the mass
  // at a vertex; 1 for vertices without material, which nothing moves.
  void set_mass(const Model& model, double inertia, double d = 0.0);
  // Adds material_scale times the material and geometric_scale times the geometric stiffness of the membrane at x (3 x
  // V, m); see MembraneTangent::stiffness, also for `project`. `stress`: N/m, one a lane of the model's blocks, in
  // place of that at x; or empty.
  void add_membrane(const Model& model, const mesh::VertexField& x, std::span<const Eigen::Vector3d> stress,
                    const MaterialScale& material_scale, double geometric_scale, bool project);
  // scale times that of the quadratics that bound the membrane's energy from above at x (3 x V, m): see
  // MajorizedTriangle.
  void add_majorized_membrane(const Model& model, const mesh::VertexField& x, double scale);
  void add_bending(const Model& model, const MaterialScale& scale);
  // The stiffness of the model's bending at x (3 x V, m), of angles where that is what it has; for `moments` and
  // `project` see AngleBending::add_stiffness.
  void add_bending_at(const Model& model, const mesh::VertexField& x, std::span<const double> moments, bool project);
  // Of springs and dampers, d^2 stiffness + d damping.
  void add_grabs(std::span<const Grab> grabs, double d);

  // scale times a part of the stiffness of pressure and moments at x (3 x V, m); none is positive semidefinite, and
  // with the skew one the matrix is not symmetric any more.
  void add_follower_loads(const Model& model, const Loads& loads, const mesh::VertexField& x, double scale,
                          MatrixPart part);
  // Rows and columns of what pins hold become 0.
  void clear_pinned(std::span<const Pin> pins);

  // Puts the displacement that the pins demand, `time_left` (s) before they are at their targets, from x on into `step`
  // and `rhs` (3 x V) and decouples what they hold: the matrix stays symmetric, and positive definite where it was.
  void constrain(const Model& model, std::span<const Pin> pins, double time_left, const mesh::VertexField& x,
                 mesh::VertexField& rhs, mesh::VertexField& step);

 private:
  using BlockPlaces = std::array<int, 9>;  // of corner pair (i, j): entry 3 i + j, from the beginning of row i

  void add_pressure(const Model& model, const Loads& loads, const mesh::VertexField& x, double scale, MatrixPart part);
  // What add_bending adds beside scale.elastic times the stiffness, patch by patch.
  void add_bending_damping(const Model& model, const MaterialScale& scale);
  void find_columns(const Model& model, mesh::VertexId v);
  void set_rows(const Model& model, std::span<const mesh::VertexId> vertices);

  BlockMatrix matrix_;
  std::vector<BlockPlaces> places_;  // one a lane of the model's blocks
  std::vector<int> columns_;         // scratch, of a row
};

}  // namespace kerf::fem
