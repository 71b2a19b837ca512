#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/draw_list.h"
#include "render/sheet_shape.h"

// Finds the border of a sheet and the lips of its cuts.
namespace kerf::render {

// Returns the edges used by only one triangle, ordered by triangle. Each has its two ends in the triangle's order, then
// the triangle's third vertex and number.
std::vector<std::array<std::int32_t, 4>> border_edges(std::span<const std::int32_t> triangles,
                                                      std::size_t num_vertices);

// Returns a segment for each border edge. `normals`: one for each vertex, see vertex_normals().
std::vector<BorderSegment> border_segments(const Mesh& mesh, const std::vector<Float3>& normals);

}  // namespace kerf::render
