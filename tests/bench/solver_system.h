#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/model/tangent_matrix.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/triangle_mesh.h"

// Linear systems that solvers are compared by.
namespace kerf::bench {

// One step of implicit Euler, linearised where it begins: A dx = b with A = M + h^2 K, b = M h v + h^2 (f + M g).
struct System {
  fem::TangentMatrix tangent;
  linear::VertexField b;                // 3 x V, kg m
  Eigen::MatrixXd dense;                // A; empty until it is asked for
  linear::VertexField exact;            // 3 x V, m: dx
  std::vector<Eigen::Matrix3d> frames;  // of the vertices
  linear::VertexField positions;        // 3 x V, m
};

// At a state; `step` (s): h.
System system_at(const fem::Model& model, const fem::Loads& loads, const fem::State& state, double step);

// Two corners pinned.
fem::Loads corners_pinned(const mesh::TriangleMesh& mesh, int side);

// Flat and at rest, at z = 0.
fem::State flat(const mesh::TriangleMesh& mesh);

// Carries the state on by implicit Euler, solved well.
void fall(const fem::Model& model, const fem::Loads& loads, double step, int steps, fem::State& state);

}  // namespace kerf::bench
