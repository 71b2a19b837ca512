#include "server/core/mesh/build/element_names.h"

namespace kerf::mesh {

std::string ElementNames::triangle(std::int32_t triangle) const {
  return of_triangle ? of_triangle(triangle) : "triangle " + std::to_string(triangle);
}

std::string ElementNames::vertex(std::int32_t vertex) const {
  return of_vertex ? of_vertex(vertex) : "vertex " + std::to_string(vertex);
}

std::string ElementNames::triangles(std::span<const std::int32_t> some) const {
  std::string list = of_triangle ? "" : some.size() == 1 ? "triangle " : "triangles ";
  for (std::size_t i = 0; i < some.size(); ++i) {
    list += i == 0 ? "" : some.size() == 2 ? " and " : ", ";
    list += of_triangle ? of_triangle(some[i]) : std::to_string(some[i]);
  }
  return list;
}

std::string ElementNames::edge(std::int32_t a, std::int32_t b) const {
  if (of_vertex) return "the edge between " + of_vertex(a) + " and " + of_vertex(b);
  return "edge (" + std::to_string(a) + ", " + std::to_string(b) + ")";
}

}  // namespace kerf::mesh
