#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace kerf::mesh {

// Names triangles and vertices in messages: by their numbers, unless a file has better names.
struct ElementNames {
  std::function<std::string(std::int32_t triangle)> of_triangle;
  std::function<std::string(std::int32_t vertex)> of_vertex;

  // Return "triangle 5", "vertex 7", "triangles 5 and 21" ("triangles 5, 21, 30" if there are more) and "edge (7, 8)",
  // or the same with the names that the functions give.
  [[nodiscard]] std::string triangle(std::int32_t triangle) const;
  [[nodiscard]] std::string vertex(std::int32_t vertex) const;
  [[nodiscard]] std::string triangles(std::span<const std::int32_t> some) const;
  [[nodiscard]] std::string edge(std::int32_t a, std::int32_t b) const;
};

}  // namespace kerf::mesh
