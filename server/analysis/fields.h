#pragma once

#include <Eigen/Core>

#include "server/fem/model.h"
#include "server/mesh/ids.h"
#include "server/mesh/vertex_field.h"

// What is computed of a state beyond what moves it.
namespace kerf::analysis {

// Along material x and y: xx, yy, xy (the tensor's component, so half the shear angle).
struct InPlane {
  Eigen::Vector3d strain = Eigen::Vector3d::Zero();  // -, co-rotational (Biot)
  Eigen::Vector3d stress = Eigen::Vector3d::Zero();  // Pa, its conjugate: force by undeformed area
  double area = 0.0;                                 // m^2, undeformed
};

// Of a solid slot at x (3 x V, m).
InPlane in_plane(const fem::Model& model, mesh::TriangleId slot, const mesh::VertexField& x);

// Of a vertex: the mean of its triangles weighted by area, so that of one side of a cut alone.
InPlane in_plane_at(const fem::Model& model, mesh::VertexId vertex, const mesh::VertexField& x);

}  // namespace kerf::analysis
