#pragma once

#include <optional>

#include <Eigen/Core>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/model.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::sheet {

// A piece that is pushed where nothing holds it: it has no equilibrium.
struct UnheldPiece {
  std::int32_t piece = 0;
  Eigen::Vector2d material{0.0, 0.0};  // m, one of its vertices
  int component = 0;                   // 0..2, of the world
  double force = 0.0;                  // N, gravity and dead forces on it along that, in all
};

// Returns the first piece that dead forces push along an axis (x, y or z) along which no vertex of it is held. Forces
// that cancel up to rounding do not count. Pieces under pressure, which turns with them, are left to the equilibrium
// search; so are moments.
// `loads`: pins, gravity and external forces in force.
std::optional<UnheldPiece> find_unheld(const mesh::TriangleMesh& mesh, const fem::Model& model,
                                       const fem::Loads& loads);

}  // namespace kerf::sheet
