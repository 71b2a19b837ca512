#pragma once

#include <optional>

#include <Eigen/Core>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/model.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::sheet {

// A piece without equilibrium: forces push it along an axis along which nothing holds it.
struct UnheldPiece {
  std::int32_t piece = 0;
  Eigen::Vector2d material{0.0, 0.0};  // m, material coordinates of one of its vertices
  int component = 0;                   // axis x, y or z of the world, 0..2
  double force = 0.0;                  // N, sum of gravity and external forces on it along that axis
};

// Returns the first piece that gravity and external forces push along an axis (x, y or z) along which none of its
// vertices is held. Forces that cancel up to rounding do not count. Pieces under pressure are left out, as it turns
// with them and may balance; moments are not considered.
// `loads`: present pins, gravity, external forces and pressure.
std::optional<UnheldPiece> find_unheld(const mesh::TriangleMesh& mesh, const fem::Model& model,
                                       const fem::Loads& loads);

}  // namespace kerf::sheet
