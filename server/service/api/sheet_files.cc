#include "server/service/api/sheet_files.h"

#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include "server/core/fem/element/state.h"
#include "server/service/api/used_vertices.h"
#include "server/service/wire/reply_codec.h"

namespace kerf::api {
namespace {

template <typename T>
std::string bytes_of(const T* data, std::size_t count) {
  std::string bytes(sizeof(T) * count, '\0');
  if (count > 0) std::memcpy(bytes.data(), data, bytes.size());
  return bytes;
}

template <typename Matrix>
std::string bytes_of(const Matrix& matrix) {
  return bytes_of(matrix.data(), static_cast<std::size_t>(matrix.size()));
}

template <typename Matrix>
void append_column(const char* keyword, const Matrix& matrix, Eigen::Index column, std::string& text) {
  text += keyword;
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    text += ' ';
    append_number(matrix(row, column), text);
  }
  text += '\n';
}

}  // namespace

v1::SheetState encode_exact_state(const sheet::Sheet& sheet, bool with_topology) {
  const std::shared_ptr<const sheet::Snapshot> snapshot = sheet.snapshot();
  const sheet::Topology& topology = *snapshot->topology;
  static_assert(sizeof(topology.triangles[0]) == 3 * sizeof(std::int32_t));
  v1::SheetState state;
  state.set_tick(sheet.tick());
  state.set_topology_version(topology.version);
  state.set_state_hash(wire::encode_hash(sheet.state_hash()));
  state.set_num_vertices(static_cast<std::int32_t>(sheet.state().x.cols()));
  state.set_positions(bytes_of(sheet.state().x));
  state.set_velocities(bytes_of(sheet.state().v));
  if (!with_topology) return state;
  state.set_material_positions(bytes_of(topology.material_positions));
  state.set_triangles(bytes_of(topology.triangles.data(), topology.triangles.size()));
  state.set_pieces(bytes_of(topology.pieces.data(), topology.pieces.size()));
  return state;
}

std::string encode_obj(const sheet::Snapshot& snapshot) {
  const sheet::Topology& topology = *snapshot.topology;
  const std::vector<std::int32_t> numbers = number_used_vertices(topology);
  std::string text = "# Kerf: metres; texture coordinates are material coordinates\n";
  text.reserve(text.size() + 64 * numbers.size() + 48 * topology.triangles.size());
  for (std::size_t v = 0; v < numbers.size(); ++v) {
    if (numbers[v] != 0) append_column("v", snapshot.positions, static_cast<Eigen::Index>(v), text);
  }
  for (std::size_t v = 0; v < numbers.size(); ++v) {
    if (numbers[v] != 0) append_column("vt", topology.material_positions, static_cast<Eigen::Index>(v), text);
  }
  for (const auto& triangle : topology.triangles) {
    if (!has_material(triangle)) continue;
    text += 'f';
    for (const mesh::VertexId vertex : triangle) {
      const std::int32_t number = numbers[static_cast<std::size_t>(vertex)];
      text += ' ';
      append_number(number, text);
      text += '/';
      append_number(number, text);
    }
    text += '\n';
  }
  return text;
}

}  // namespace kerf::api
