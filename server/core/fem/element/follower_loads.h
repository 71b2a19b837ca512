#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "server/core/fem/element/element_block.h"
#include "server/core/fem/element/loads.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Loads that turn with the sheet: Loads::pressure and Loads::edge_moments. Their forces depend on positions, and their
// work depends on the path, so that they have no energy. A line search, which needs an energy, uses their work on the
// straight path in its place. Their tangent is not symmetric either. The skew part of a uniform pressure comes from
// free borders alone (Bufler 1984, "Pressure loaded structures under large deformations"). The skew part of a moment
// comes from the rotation of its edge. MatrixPart chooses a part of the tangent.
enum class MatrixPart { kSymmetric, kSkew };

// Returns true if the pressure of a triangle or an edge moment is not 0.
[[nodiscard]] bool has_follower_loads(const Loads& loads);

// Adds the forces of pressure and edge moments at x (3 x V, m) to f (3 x V, N). Pressure comes first, by ascending
// slot, then the moments in their order.
void add_follower_forces(std::span<const ElementBlock> blocks, const Loads& loads, const linear::VertexField& x,
                         linear::VertexField& f);

// Returns the sum of the follower forces at x (3 x V, m), N. Edge moments add nothing to it.
[[nodiscard]] Eigen::Vector3d follower_resultant(std::span<const ElementBlock> blocks, const Loads& loads,
                                                 const linear::VertexField& x);

// Returns the bending energy, J, that edge moments store in the sheet and that the positions of vertices do not show;
// see EdgeMoment::compliance.
[[nodiscard]] double edge_moment_energy(const Loads& loads);

// Returns the work (J) of follower loads while vertices move straight from positions `from` to positions `to` (3 x V,
// m). It is exact for pressure. For a moment it is the work of the rotation about the mean direction of its edge, taken
// as less than half a turn.
[[nodiscard]] double follower_work(std::span<const ElementBlock> blocks, const Loads& loads,
                                   const linear::VertexField& from, const linear::VertexField& to);

// Returns block (i, j) of a part of -df/dx, N/m, for the forces f of `pressure` (Pa) on the corners of a triangle.
// `corner` holds their positions, m.
[[nodiscard]] Eigen::Matrix3d pressure_stiffness(double pressure, const std::array<Eigen::Vector3d, 3>& corner,
                                                 std::size_t i, std::size_t j, MatrixPart part);

// Computes -df/dx, N/m, for the force f that one edge moment exerts on its vertices at x (3 x V, m).
class EdgeMomentTangent {
 public:
  EdgeMomentTangent(const EdgeMoment& moment, const linear::VertexField& x);
  // Returns the symmetric or skew part of block (a, b); a and b are indices into EdgeMoment::vertex.
  [[nodiscard]] Eigen::Matrix3d stiffness(std::size_t a, std::size_t b, MatrixPart part) const;

 private:
  [[nodiscard]] Eigen::Matrix3d derivative(std::size_t a, std::size_t b) const;  // of force a by vertex b

  const EdgeMoment& moment_;
  Eigen::Matrix3d by_slope_ = Eigen::Matrix3d::Zero();  // N/m, derivative of the force for weight 1 by the arm
  Eigen::Matrix3d by_edge_ = Eigen::Matrix3d::Zero();   // N/m, derivative of that force by the vector from the first to
                                                        // the second end of the edge
};

}  // namespace kerf::fem
