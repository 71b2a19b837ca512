#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "server/core/fem/element/element_block.h"
#include "server/core/fem/element/loads.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Loads that turn with the sheet: Loads::pressure and Loads::edge_moments. What they do depends on positions, and how
// much work they do on the way there, so that no energy belongs to them: where one is needed, as by a line search,
// their work on the straight way takes its place. Nor is their tangent symmetric: of a pressure that is the same in all
// triangles the skew part belongs to free borders alone (Bufler 1984, "Pressure loaded structures under large
// deformations"), of a moment to the turning of its edge.
enum class MatrixPart { kSymmetric, kSkew };

// Whether any of them is not 0.
[[nodiscard]] bool has_follower_loads(const Loads& loads);

// f (3 x V, N) += forces at x (3 x V, m). Slots, then moments, in order.
void add_follower_forces(std::span<const ElementBlock> blocks, const Loads& loads, const mesh::VertexField& x,
                         mesh::VertexField& f);

// N, sum of the forces at x; moments have none.
[[nodiscard]] Eigen::Vector3d follower_resultant(std::span<const ElementBlock> blocks, const Loads& loads,
                                                 const mesh::VertexField& x);

// J, bending energy that moments have put into the sheet beside that of its vertices; see EdgeMoment::compliance.
[[nodiscard]] double edge_moment_energy(const Loads& loads);

// J, on the straight way `from` one field of positions `to` another (3 x V, m). Of pressure exact; a moment's is that
// of its turn about the mean direction of its edge, by less than half a turn.
[[nodiscard]] double follower_work(std::span<const ElementBlock> blocks, const Loads& loads,
                                   const mesh::VertexField& from, const mesh::VertexField& to);

// Part of -df/dx, N/m: block (i, j) of the corners `corner` (m) of a triangle under `pressure` (Pa).
[[nodiscard]] Eigen::Matrix3d pressure_stiffness(double pressure, const std::array<Eigen::Vector3d, 3>& corner,
                                                 std::size_t i, std::size_t j, MatrixPart part);

// The same of a moment, for its vertices.
class EdgeMomentTangent {
 public:
  EdgeMomentTangent(const EdgeMoment& moment, const mesh::VertexField& x);
  [[nodiscard]] Eigen::Matrix3d stiffness(std::size_t a, std::size_t b, MatrixPart part) const;

 private:
  [[nodiscard]] Eigen::Matrix3d derivative(std::size_t a, std::size_t b) const;  // of force a by vertex b

  const EdgeMoment& moment_;
  Eigen::Matrix3d by_slope_ = Eigen::Matrix3d::Zero();  // of the force for weight 1 by the arm, N/m
  Eigen::Matrix3d by_edge_ = Eigen::Matrix3d::Zero();   // by the edge from its first to its second end
};

}  // namespace kerf::fem
