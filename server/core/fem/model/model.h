#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/base/phase_observer.h"
#include "server/core/fem/element/bending_forces.h"
#include "server/core/fem/element/element_block.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/material.h"
#include "server/core/fem/element/material_table.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/bending_operator.h"
#include "server/core/fem/model/rest_elements.h"
#include "server/core/fem/model/stable_step.h"
#include "server/core/fem/model/vertex_masses.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/mesh_edit.h"

namespace kerf::mesh {
class TriangleMesh;
}

namespace kerf::fem {

// Energies of a state, J.
struct Energies {
  double membrane = 0.0;
  double bending = 0.0;
  double gravity = 0.0;  // -sum m g.x
  double kinetic = 0.0;
  [[nodiscard]] double total() const { return membrane + bending + gravity + kinetic; }
};

struct Momentum {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   // kg m/s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  // kg m^2/s, about the world's origin
};

// The discrete elastic sheet, derived from the rest shape of a mesh, flat or curved, and the materials. It is made of
// four parts:
//   elements(): the constants of every triangle. Membrane: linear triangles, W = A/2 e.C e; co-rotational with
//               e = U - I, F = R U (Biot strain), or with Green's strain: see MembraneLaw.
//   masses(): the lumped masses of vertices and their mass damping.
//   bending(): the bending stiffness, with clamps at the border.
//   stiffness_bound(): the bound that stable steps follow from.
// No edit moves the borders between regions of the mesh, so cuts keep the material at each place. A model is derived
// from mesh and materials alone. Two models of equal mesh and materials are equal bit for bit, whatever edits led to
// them.
class Model {
 public:
  // Uses one material for all triangles, whatever the regions of the mesh. `material` must be valid (see validate).
  Model(const mesh::TriangleMesh& mesh, const Material& material, MembraneLaw law = MembraneLaw::kCorotational);
  // Takes 1..kMaxMaterials materials: at least one for each region of the mesh, or a single one for all.
  Model(const mesh::TriangleMesh& mesh, std::span<const Material> materials,
        MembraneLaw law = MembraneLaw::kCorotational);

  // Follows an edit that the mesh has already made. Recomputes only the rewritten slots, the bending patches that touch
  // them and the masses near them. The result equals a fresh model of the same materials.
  MassChange apply(const mesh::TriangleMesh& mesh, const mesh::MeshEdit& edit);
  // Follows any number of edits, made or reverted, given the slots they rewrote. `rewritten` is sorted and unique, and
  // holds all such slots that the mesh still has. If the mesh has fewer slots and vertices than the model, the last
  // ones are dropped. `observer` may be null.
  MassChange follow(const mesh::TriangleMesh& mesh, const std::vector<mesh::TriangleId>& rewritten,
                    PhaseObserver* observer = nullptr);

  // Clamps the slope of the sheet at border edges whose two ends are both in `clamps`. `clamps` is sorted by vertex and
  // unique, and replaces earlier clamps. Affects bending only, and only flat rest shapes.
  void set_clamps(const mesh::TriangleMesh& mesh, std::vector<Clamp> clamps);
  // Switches bending to angles and back; see BendingOperator::bend_by_angles().
  void bend_by_angles(const mesh::TriangleMesh& mesh) { bending_.bend_by_angles({mesh, elements_}); }
  void bend_by_matrix() { bending_.bend_by_matrix(); }

  // Returns a moment along the border edge opposite corner `edge` of a solid slot; see make_edge_moment().
  [[nodiscard]] EdgeMoment edge_moment(const mesh::TriangleMesh& mesh, mesh::TriangleId slot, int edge,
                                       double moment_per_length) const {
    return make_edge_moment({mesh, elements_}, bending_.clamps(), slot, edge, moment_per_length);
  }

  [[nodiscard]] const RestElements& elements() const { return elements_; }
  [[nodiscard]] const VertexMasses& masses() const { return masses_; }
  [[nodiscard]] const BendingOperator& bending() const { return bending_; }
  // 1/s^2, upper bound of the largest eigenvalue of M^-1 K at rest.
  [[nodiscard]] const StiffnessBound& stiffness_bound() const { return stiffness_bound_; }

  // Shortcuts to the most needed constants of the parts.
  [[nodiscard]] int num_vertices() const { return elements_.num_vertices(); }
  [[nodiscard]] int num_slots() const { return elements_.num_slots(); }
  [[nodiscard]] const MaterialTable& materials() const { return elements_.materials(); }
  [[nodiscard]] std::span<const ElementBlock> element_blocks() const { return elements_.blocks(); }
  [[nodiscard]] std::span<const double> mass() const { return masses_.mass(); }             // kg, length V
  [[nodiscard]] std::span<const double> inverse_mass() const { return masses_.inverse(); }  // 1/kg, length V
  // Vertices whose row of the stiffness matrix may have changed columns or elements since the last apply(), follow() or
  // set_clamps(); unique.
  [[nodiscard]] std::span<const mesh::VertexId> changed_rows() const;

  // Sets f (3 x V, N) to the membrane and bending forces at x (3 x V, m), without damping. f must have V columns.
  void internal_forces(const linear::VertexField& x, linear::VertexField& f) const;
  // Returns the energies of a state; gravity in m/s^2.
  [[nodiscard]] Energies energies(const State& state, const Eigen::Vector3d& gravity) const;
  [[nodiscard]] Momentum momentum(const State& state) const;
  [[nodiscard]] Eigen::Vector3d centre_of_mass(const linear::VertexField& x) const;  // m

  // Hash of every number derived from mesh and material, bit for bit, including those that only later edits read. For
  // tests.
  [[nodiscard]] std::uint64_t hash() const;

 private:
  [[nodiscard]] StiffnessProblem stiffness_problem(const mesh::TriangleMesh& mesh) const;

  RestElements elements_;
  VertexMasses masses_;
  BendingOperator bending_;
  StiffnessBound stiffness_bound_;
};

}  // namespace kerf::fem
