#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

// Air drag of each triangle, quadratic in the velocity u of the air relative to it (n unit normal, A current area):
//   f = 1/2 rho A (normal_drag |u.n| (u.n) n + tangential_drag |u_t| u_t),   u_t = u - (u.n) n.
// Each corner gets a third of f. Velocity and density of the air are the same everywhere; density 0 switches drag off.
struct Wind {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // m/s
  double air_density = 0.0;                            // kg/m^3, >= 0; air is 1.2
  double normal_drag = 1.2;                            // -, >= 0; a flat plate across the stream has ~1.2
  double tangential_drag = 0.02;                       // -, >= 0; skin friction
};

// Prescribed motion of a vertex (Dirichlet condition). Its `fixed` components reach `target` with `velocity` when the
// step ends. Within the step they follow the straight line target - velocity * (time left). The other components are
// free. A pin at rest has velocity 0.
struct Pin {
  mesh::VertexId vertex = mesh::kNone;
  Eigen::Vector3d target = Eigen::Vector3d::Zero();    // m, position when the step ends
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // m/s
  std::array<bool, 3> fixed{true, true, true};         // x, y, z

  [[nodiscard]] bool is_whole() const { return fixed[0] && fixed[1] && fixed[2]; }
  // Returns `value` in the fixed components and `free` in the others.
  [[nodiscard]] Eigen::Vector3d held(const Eigen::Vector3d& value, const Eigen::Vector3d& free) const {
    return {fixed[0] ? value.x() : free.x(), fixed[1] ? value.y() : free.y(), fixed[2] ? value.z() : free.z()};
  }
};

// A stiff spring from the point sum_k weights[k] x(vertices[k]) to a moving target, treated implicitly by every
// integrator. Any stiffness is stable. The higher it is, the more nearly the point reaches the target within a substep.
struct Grab {
  std::array<mesh::VertexId, 3> vertices{mesh::kNone, mesh::kNone, mesh::kNone};  // corners of one triangle; kNone for
                                                                                  // an unused one, with weight 0
  Eigen::Vector3d weights{1.0, 0.0, 0.0};                                         // -, >= 0, sum 1
  Eigen::Vector3d target =
      Eigen::Vector3d::Zero();  // m, when the step ends; moves along target - velocity * (time left)
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // m/s, of the target
  double stiffness = 0.0;                              // N/m, >= 0
  double damping = 0.0;                                // N s/m, >= 0, relative to the target's velocity
};

// A moment M along a border edge that turns with the sheet. Model::edge_moment makes it, for the current triangles. It
// does the work M dphi on the slope phi of the sheet across the edge. That is the slope that a clamp would hold, and
// that a free edge takes from its bending patch. The forces on the vertices of the patch have no resultant, and their
// moment about the edge is M in any position. They grow no further once the arm across the edge has shrunk below a
// twentieth of `arm`.
struct EdgeMoment {
  std::array<mesh::VertexId, 6> vertex{mesh::kNone, mesh::kNone, mesh::kNone,
                                       mesh::kNone, mesh::kNone, mesh::kNone};  // of the bending patch, in the order of
                                                                                // BendingPatch
  std::array<double, 6> weight{};  // -, sum 0; sum_a weight[a] x(vertex[a]) is the slope across the edge times `arm`
  std::size_t edge = 0;            // 0..2: the edge opposite that corner of the triangle
  double arm = 0.0;                // m, > 0, height of the triangle over the edge at rest
  // 1/(N m), >= 0: rotation of the slope by a moment of 1 while all vertices are fixed. The positions of vertices alone
  // give the border triangle no bending moment at the edge. The moment therefore stores the additional energy
  // compliance moment^2 / 2. The interaction of two moments on one triangle, at a corner of the sheet, is neglected. 0
  // on a curved rest shape.
  double compliance = 0.0;
  double moment = 0.0;  // N m; > 0 turns the outside of the edge toward the triangle's normal
};

// All external actions on the sheet during one step.
struct Loads {
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};  // m/s^2
  Wind wind;
  linear::VertexField external_forces;  // N, 3 x V, or 3 x 0 for none
  // Pa, one a triangle slot, or empty. Pressure p pushes along the normal (x1 - x0) x (x2 - x0) of the deformed
  // triangle. Its force is p (x1 - x0) x (x2 - x0) / 2, a third to each corner.
  std::vector<double> pressure;
  std::vector<EdgeMoment> edge_moments;
  std::vector<Pin> pins;    // each vertex at most once
  std::vector<Grab> grabs;  // a grab never moves a wholly pinned vertex, only its other vertices

  [[nodiscard]] bool has_external_forces() const { return external_forces.cols() > 0 && !external_forces.isZero(0.0); }
};

}  // namespace kerf::fem
