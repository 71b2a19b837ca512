#pragma once

#include <cstdint>

#include "server/core/mesh/mesh_editor.h"
#include "server/core/mesh/refine/size_field.h"

namespace kerf::mesh {

// Inserts points into the solid triangles until none is much larger than the size given by `sizes` (m). Each point goes
// above an edge of the border, or of a triangle that is small enough. It completes a triangle with sides of the length
// wanted there. Fixed edges are not split. So rows of near equilateral triangles grow from the border inwards (Rebay
// 1993, "Efficient unstructured mesh generation by means of Delaunay triangulation and Bowyer-Watson algorithm"; points
// as in Engwirda and Ivers 2016, "Off-centre Steiner points for Delaunay-refinement on curved surfaces"). The mesh must
// be constrained Delaunay, and is after. Returns false if more than `max_points` would be needed, or slots are
// exhausted.
bool fill_from_border(MeshEditor& editor, const SizeField& sizes, std::int64_t max_points);

}  // namespace kerf::mesh
