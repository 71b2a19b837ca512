#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/fem/loads.h"
#include "server/fem/model.h"
#include "server/fem/state.h"
#include "server/fem/tangent_matrix.h"
#include "server/mesh/triangle_mesh.h"

namespace kerf::bench {

// A sheet of 1 m x 1 m that has fallen from the horizontal, two corners pinned.
struct FallenSheet {
  mesh::TriangleMesh mesh;
  fem::Model model;
  fem::State state;
  fem::Loads loads;
};

// side x side vertices, for 0.5 s.
FallenSheet let_fall(const fem::Material& material, int side);
inline constexpr int kMostFallen = 50;

// A grid of side x side vertices; with `slits`, cut through four times along 0.6 m.
mesh::TriangleMesh make_sheet(int side, bool slits);
// `fallen`, of kMostFallen x kMostFallen vertices, on the mesh of make_sheet, and then a step of 1/240 s: the fall of a
// large sheet takes hours.
FallenSheet refine(const FallenSheet& fallen, const fem::Material& material, mesh::TriangleMesh mesh, int side);

// One step of implicit Euler, linearised where it begins: A dx = b with A = M + h^2 K, b = M h v + h^2 (f + M g).
struct System {
  fem::TangentMatrix tangent;
  mesh::VertexField b;                  // 3 x V, kg m
  Eigen::MatrixXd dense;                // A
  mesh::VertexField exact;              // 3 x V, m: dx
  std::vector<Eigen::Matrix3d> frames;  // of the vertices
  mesh::VertexField positions;          // 3 x V, m
};

// dt: s. Without `dense`, and `exact` has what pins demand alone.
System linearise(const FallenSheet& sheet, double dt);

}  // namespace kerf::bench
