#include "render/borders.h"

#include <algorithm>
#include <limits>

namespace kerf::render {

namespace {

constexpr float kSharpestMitre = 0.5F;  // Cosine of half the angle between strips; below it they overlap at corners.

// Returns the unit vector in a triangle's plane that is perpendicular to its border edge and points inwards. `edge`:
// see border_edges().
Float3 inward_of(const Mesh& mesh, const std::array<std::int32_t, 4>& edge) {
  const Float3 start = position(mesh, edge[0]);
  const Float3 along = difference(position(mesh, edge[1]), start);
  const Float3 normal = cross(along, difference(position(mesh, edge[2]), start));
  return unit(cross(normal, along), Float3{});
}

// Returns the vector along which the strips of the two border edges of a vertex meet. It is longer than 1, so that both
// strips keep their width. `own`: inward unit vector of one edge; `sum`: sum of the vectors of both edges.
Float3 mitred(Float3 own, Float3 sum) {
  const Float3 middle = unit(sum, own);
  const float cosine = dot(middle, own);
  if (cosine < kSharpestMitre) return own;
  return {middle[0] / cosine, middle[1] / cosine, middle[2] / cosine};
}

}  // namespace

std::vector<std::array<std::int32_t, 4>> border_edges(std::span<const std::int32_t> triangles,
                                                      std::size_t num_vertices) {
  // Represents an edge in the linked list of all edges with the same lower vertex id. Few edges share it, so lists are
  // short.
  struct Edge {
    std::int32_t upper;
    std::int32_t uses;
    std::size_t next;
  };
  constexpr std::size_t kEnd = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> first(num_vertices, kEnd);
  std::vector<Edge> edges;
  edges.reserve(triangles.size());
  std::vector<std::size_t> edge_of(triangles.size());  // Index in `edges` of the side that begins at corner i.
  const auto next_corner = [](std::size_t i) { return i % 3 == 2 ? i - 2 : i + 1; };
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto [lower, upper] = std::minmax({triangles[i], triangles[next_corner(i)]});
    std::size_t& head = first[static_cast<std::size_t>(lower)];
    std::size_t at = head;
    while (at != kEnd && edges[at].upper != upper) at = edges[at].next;
    if (at == kEnd) {
      at = edges.size();
      edges.push_back({upper, 0, head});
      head = at;
    }
    ++edges[at].uses;
    edge_of[i] = at;
  }
  std::vector<std::array<std::int32_t, 4>> borders;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const std::size_t next = next_corner(i);
    if (edges[edge_of[i]].uses != 1) continue;
    borders.push_back({triangles[i], triangles[next], triangles[next_corner(next)], static_cast<std::int32_t>(i / 3)});
  }
  return borders;
}

std::vector<BorderSegment> border_segments(const Mesh& mesh, const std::vector<Float3>& normals) {
  const auto edges = border_edges(mesh.triangles, normals.size());
  std::vector<Float3> inward;
  inward.reserve(edges.size());
  std::vector<Float3> sums(normals.size(), Float3{});
  for (const auto& edge : edges) {
    inward.push_back(inward_of(mesh, edge));
    for (const std::size_t end : {0U, 1U}) {
      Float3& sum = sums[static_cast<std::size_t>(edge[end])];
      for (std::size_t k = 0; k < 3; ++k) sum[k] += inward.back()[k];
    }
  }
  std::vector<BorderSegment> segments;
  segments.reserve(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const auto start = static_cast<std::size_t>(edges[i][0]);
    const auto end = static_cast<std::size_t>(edges[i][1]);
    segments.push_back({position(mesh, edges[i][0]), position(mesh, edges[i][1]), mitred(inward[i], sums[start]),
                        mitred(inward[i], sums[end]), normals[start], normals[end],
                        look_of(mesh, static_cast<std::size_t>(edges[i][3]))});
  }
  return segments;
}

}  // namespace kerf::render
