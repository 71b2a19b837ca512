#pragma once

#include <vector>

#include <Eigen/SparseCore>

#include "server/core/fem/element/material.h"
#include "server/core/mesh/triangle_mesh.h"

// Condition numbers of the matrix A = M + h^2 K of implicit steps, of a flat sheet at rest, without bending.
//
// The thesis speaks of the global stiffness matrix, and of numbers within 10 before a cut. K itself is singular, and A
// in SI units at h = 1/60 s has 1e7 to 1e8. A has 10 only if the mass decides, with a far shorter step or other units.
namespace kerf::evaluation {

class ConditionMatrix {
 public:
  // Motion in the plane of the sheet, of vertices that are not held. M is lumped. Out of the plane A is M alone.
  ConditionMatrix(const mesh::TriangleMesh& mesh, const fem::Material& material,
                  const std::vector<mesh::VertexId>& held);

  // Largest over smallest eigenvalue of A, to 3 digits.
  [[nodiscard]] double condition(double step) const;
  // The same of D^-1/2 A D^-1/2, D = diag A: what conjugate gradients with Jacobi's preconditioner see.
  [[nodiscard]] double scaled_condition(double step) const;
  // Step (s) with which condition() has this value, > that of M.
  [[nodiscard]] double step_of(double condition) const;

 private:
  [[nodiscard]] Eigen::SparseMatrix<double> matrix(double step) const;

  Eigen::SparseMatrix<double> stiffness_;  // N/m
  Eigen::VectorXd mass_;                   // kg
};

}  // namespace kerf::evaluation
