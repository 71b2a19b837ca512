#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/components.h"
#include "server/core/scene/conditions.h"

// Finds the vertices, edges and triangles of a Region on a mesh.
namespace kerf::scene {

// Returns the vertices of a region on the mesh as it is now, sorted, unique; there may be none. `region` must be valid.
// Error: kInvalidArgument UNKNOWN_VERTEX, with a path that begins with `field`.
Result<std::vector<mesh::VertexId>> find_vertices(const mesh::TriangleMesh& mesh, const PlacedRegion& region,
                                                  const std::string& field);
// Returns the vertices of all regions together, sorted, unique. Errors: those of place() and find_vertices(), and
// REGION_EMPTY if a region has none. `field`: the path of the list.
Result<std::vector<mesh::VertexId>> find_pins(const mesh::TriangleMesh& mesh,
                                              std::span<const ComponentPlace> components,
                                              const std::vector<Region>& regions, const std::string& field);
// Leaves out the listed vertices that cuts or undos have removed or left without material.
void forget_removed(const mesh::TriangleMesh& mesh, PlacedRegion& region);
// Returns the error kInvalidArgument REGION_EMPTY for a region without vertices. `field`: its path.
Error no_vertex_in(const std::string& field);

// An edge of the border or of a lip.
struct BorderEdge {
  mesh::TriangleId slot = mesh::kNone;
  int edge = 0;  // edge of the slot opposite this corner
  std::array<mesh::VertexId, 2> ends{mesh::kNone, mesh::kNone};
  double length = 0.0;  // m, in material coordinates
};

// Returns the border edges and lips with both ends in `region`, which is a sorted list of vertices.
std::vector<BorderEdge> edges_in(const mesh::TriangleMesh& mesh, const std::vector<mesh::VertexId>& region);
// Returns the solid slots with all corners in `region`, which is a sorted list of vertices.
std::vector<mesh::TriangleId> triangles_in(const mesh::TriangleMesh& mesh, const std::vector<mesh::VertexId>& region);
// Returns the solid slots of a region, ascending. For a box, line or curve these are the slots whose centroid is in it
// and on the wanted side. For listed vertices they are those with all corners listed. Errors: those of find_vertices().
// kInvalidArgument REGION_WITHOUT_TRIANGLES for edges of the bounding box, a border and a nearest vertex.
Result<std::vector<mesh::TriangleId>> find_triangles(const mesh::TriangleMesh& mesh, const PlacedRegion& region,
                                                     const std::string& field);
// Returns the area of a solid slot in material coordinates, m^2.
double rest_area(const mesh::TriangleMesh& mesh, mesh::TriangleId slot);

// Updates pins after an edit. A new vertex is pinned if all its sources with positive weight are: a copy of a pinned
// vertex, or a vertex on an edge between two pinned ones. Vertices left without material are unpinned. `pinned`:
// sorted, unique, before and after.
void inherit_pins(const mesh::MeshEdit& edit, std::vector<mesh::VertexId>& pinned);

}  // namespace kerf::scene
