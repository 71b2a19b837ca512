#pragma once

#include <cstdint>

#include "server/core/mesh/mesh_editor.h"
#include "server/core/mesh/refine/size_field.h"

namespace kerf::mesh {

// Inserts points into the solid triangles until none is much larger than the size given by `sizes` (m). Each new point
// lies above an edge of the front: a fixed edge, or an edge of a triangle that is small enough. With that edge it forms
// a triangle whose other sides have the length wanted there. So rows of nearly equilateral triangles grow from the
// border inwards. The method is that of Rebay (1993, "Efficient unstructured mesh generation by means of Delaunay
// triangulation and Bowyer-Watson algorithm"). The points are those of Engwirda and Ivers (2016, "Off-centre Steiner
// points for Delaunay-refinement on curved surfaces"). Fixed edges are not split. The mesh must be constrained
// Delaunay, and stays so. Returns false if more than `max_points` would be needed, or the editor has no slots left.
bool fill_from_border(MeshEditor& editor, const SizeField& sizes, std::int64_t max_points);

}  // namespace kerf::mesh
