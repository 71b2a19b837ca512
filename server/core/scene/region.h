#pragma once

#include <array>
#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/conditions.h"

// Finds what a Region names on a mesh.
namespace kerf::sheet {

// Returns the vertices that a region names on the mesh as it is now, perhaps none: sorted, unique. `region` must be
// valid. Errors: kInvalidArgument UNKNOWN_VERTEX with the path below `field`.
Result<std::vector<mesh::VertexId>> find_vertices(const mesh::TriangleMesh& mesh, const Region& region,
                                                  const std::string& field);
// Returns the vertices of all regions together. Error: REGION_EMPTY if one of them names none. `field`: the path of the
// list.
Result<std::vector<mesh::VertexId>> find_pins(const mesh::TriangleMesh& mesh, const std::vector<Region>& regions,
                                              const std::string& field);
// Makes the error kInvalidArgument REGION_EMPTY of a region that names no vertex.
Error no_vertex_in(const std::string& field);

// A border edge of the opened mesh, lips among them, both ends of which are in a region.
struct BorderEdge {
  mesh::TriangleId slot = mesh::kNone;
  int edge = 0;  // opposite that corner
  std::array<mesh::VertexId, 2> ends{mesh::kNone, mesh::kNone};
  double length = 0.0;  // m, undeformed
};

// `region`: sorted vertices.
std::vector<BorderEdge> edges_in(const mesh::TriangleMesh& mesh, const std::vector<mesh::VertexId>& region);
// Returns the solid slots all corners of which are in the region.
std::vector<mesh::TriangleId> triangles_in(const mesh::TriangleMesh& mesh, const std::vector<mesh::VertexId>& region);
// Returns the solid slots that a region names by itself, ascending. For a box, a line or a curve these are the ones
// whose centroid is in it, on its side; for listed vertices, the ones with all corners listed. Errors: those of
// find_vertices, and kInvalidArgument REGION_WITHOUT_TRIANGLES for edges of the bounding box, a border and a nearest
// vertex.
Result<std::vector<mesh::TriangleId>> find_triangles(const mesh::TriangleMesh& mesh, const Region& region,
                                                     const std::string& field);
// m^2, in material coordinates, of a solid slot.
double rest_area(const mesh::TriangleMesh& mesh, mesh::TriangleId slot);

// Updates pins after an edit: a new vertex is pinned if all its sources of positive weight are. So are both copies of a
// split vertex, and a new vertex on an edge between two pinned ones. Vertices left without material are unpinned.
// `pinned`: sorted, unique; stays so.
void inherit_pins(const mesh::MeshEdit& edit, std::vector<mesh::VertexId>& pinned);

}  // namespace kerf::sheet
