#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "client/cpp/mirror.h"
#include "kerf/v1/sheets.pb.h"
#include "server/service/wire/quantise.h"

namespace kerf::ws_test {

template <typename T>
std::vector<T> unpack(const std::string& bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

// Returns a difference between viewer and server; empty if they agree: every triangle, piece and material position
// equal, every coordinate the integer that the server's own position gives in the mirror's box.
inline std::string difference(const client::Mirror& mirror, const v1::SheetState& state) {
  if (mirror.tick() != state.tick()) return "tick";
  if (mirror.topology_version() != state.topology_version()) return "topology_version";
  if (mirror.num_vertices() != state.num_vertices()) return "num_vertices";
  const std::vector<double> positions = unpack<double>(state.positions());
  const v1::Box3& box = mirror.box();
  const wire::FrameBox frame_box{
      {box.min().x(), box.min().y(), box.min().z()},
      {box.max().x() - box.min().x(), box.max().y() - box.min().y(), box.max().z() - box.min().z()}};
  const std::vector<std::uint16_t> quantised = wire::quantise(positions, frame_box);
  if (mirror.quantised_positions().size() != quantised.size()) return "number of positions";
  for (std::size_t i = 0; i < quantised.size(); ++i) {
    if (mirror.quantised_positions()[i] != quantised[i]) return "position of vertex " + std::to_string(i / 3);
  }
  const std::vector<std::int32_t> triangles = unpack<std::int32_t>(state.triangles());
  if (triangles.size() != 3 * mirror.triangles().size()) return "number of slots";
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (mirror.triangles()[i / 3][i % 3] != triangles[i]) return "triangle " + std::to_string(i / 3);
  }
  if (mirror.pieces() != unpack<std::int32_t>(state.pieces())) return "pieces";
  const std::vector<double> material = unpack<double>(state.material_positions());
  if (material.size() != mirror.material_positions().size()) return "number of material positions";
  for (std::size_t i = 0; i < material.size(); ++i) {
    if (mirror.material_positions()[i] != static_cast<float>(material[i])) {
      return "material position of vertex " + std::to_string(i / 2);
    }
  }
  return {};
}

}  // namespace kerf::ws_test
