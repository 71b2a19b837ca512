#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <string>
#include <vector>

#include "server/core/sheet/snapshot.h"

// Shares code between the file formats of a sheet.
namespace kerf::api {

inline bool has_material(const std::array<mesh::VertexId, 3>& triangle) {
  return triangle[0] != mesh::kNone;
}

// Returns for each vertex its number in the file, 1, 2, ... in the order of ids; 0 if no triangle uses it.
inline std::vector<std::int32_t> number_used_vertices(const sheet::Topology& topology) {
  std::vector<std::int32_t> numbers(topology.vertex_versions.size(), 0);
  for (const auto& triangle : topology.triangles) {
    if (!has_material(triangle)) continue;
    for (const mesh::VertexId vertex : triangle) numbers[static_cast<std::size_t>(vertex)] = 1;
  }
  std::int32_t next = 0;
  for (std::int32_t& number : numbers) {
    if (number != 0) number = ++next;
  }
  return numbers;
}

// Appends a number as text that reads back to the same number.
template <typename T>
void append_number(T value, std::string& text) {
  std::array<char, 32> digits{};
  const auto [end, fault] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  static_cast<void>(fault);  // 32 characters hold every double and every integer.
  text.append(digits.data(), end);
}

}  // namespace kerf::api
