#include "server/core/sheet/unheld.h"

#include <array>
#include <cmath>
#include <vector>

namespace kerf::sheet {

namespace {

constexpr double kImbalance = 1.0e-9;  // -; a sum of forces counts as zero if it is below this times the sum of their
                                       // magnitudes

struct Balance {
  std::array<bool, 3> held{false, false, false};
  bool is_pressed = false;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();        // N
  Eigen::Vector3d magnitude = Eigen::Vector3d::Zero();  // N, sum of the magnitudes
  Eigen::Vector2d material{0.0, 0.0};                   // m
};

}  // namespace

std::optional<UnheldPiece> find_unheld(const mesh::TriangleMesh& mesh, const fem::Model& model,
                                       const fem::Loads& loads) {
  std::vector<Balance> pieces(static_cast<std::size_t>(mesh.num_pieces()));
  const auto piece_of = [&](mesh::VertexId v) -> Balance& {
    return pieces[static_cast<std::size_t>(mesh.piece(mesh.triangle_at(v)))];
  };
  const bool has_external = loads.external_forces.cols() > 0;
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    if (!mesh.has_material(v)) continue;
    Balance& balance = piece_of(v);
    const Eigen::Vector3d weight = model.mass()[static_cast<std::size_t>(v)] * loads.gravity;
    Eigen::Vector3d force = weight;
    if (has_external) force += loads.external_forces.col(v);
    balance.sum += force;
    balance.magnitude += weight.cwiseAbs();
    if (has_external) balance.magnitude += loads.external_forces.col(v).cwiseAbs();
    balance.material = mesh.rest_position(v);
  }
  for (const fem::Pin& pin : loads.pins) {
    if (!mesh.has_material(pin.vertex)) continue;
    for (std::size_t k = 0; k < 3; ++k) piece_of(pin.vertex).held[k] |= pin.fixed[k];
  }
  for (std::size_t t = 0; t < loads.pressure.size(); ++t) {
    const auto slot = static_cast<mesh::TriangleId>(t);
    if (loads.pressure[t] != 0.0 && mesh.is_solid(slot)) {
      pieces[static_cast<std::size_t>(mesh.piece(slot))].is_pressed = true;
    }
  }
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    for (int k = 0; k < 3 && !pieces[p].is_pressed; ++k) {
      if (pieces[p].held[static_cast<std::size_t>(k)]) continue;
      if (std::abs(pieces[p].sum[k]) <= kImbalance * pieces[p].magnitude[k]) continue;
      return UnheldPiece{static_cast<std::int32_t>(p), pieces[p].material, k, pieces[p].sum[k]};
    }
  }
  return std::nullopt;
}

}  // namespace kerf::sheet
