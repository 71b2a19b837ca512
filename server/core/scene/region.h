#pragma once

#include <array>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/cut/curve.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::sheet {

inline constexpr std::size_t kMaxRegions = 64;                // in one list
inline constexpr std::size_t kMaxListedVertices = 1'000'000;  // in all vertex lists of one list of regions together
inline constexpr double kMaxMaterialCoordinate = 1.0e4;       // m
inline constexpr double kMaxWorldCoordinate = 1.0e6;          // m, a component of any world vector

// Edges of the material bounding box.
enum class RegionEdge {
  kTop,         // y = maximum
  kBottom,      // y = minimum
  kLeft,        // x = minimum
  kRight,       // x = maximum
  kCorners,     // the vertex nearest to each corner of the bounding box; the smallest id of several
  kTopCorners,  // of those, the two at y = maximum
};

// Closed box in material coordinates.
struct MaterialBox {
  Eigen::Vector2d min{0.0, 0.0};  // m
  Eigen::Vector2d max{0.0, 0.0};  // m, each >= min's
};

// All closer to the segment from a to b than `within`, in material coordinates.
struct MaterialLine {
  enum class Side { kBoth, kLeft, kRight };  // of the two lips of a cut along the line, looking from a to b

  Eigen::Vector2d a{0.0, 0.0};  // m
  Eigen::Vector2d b{0.0, 0.0};  // m; may be a
  double within = 0.0;          // m, 0..kMaxMaterialCoordinate; 0: kRegionTolerance of the sheet's size
  Side side = Side::kBoth;
};

// All closer to a curve than `within`, in material coordinates.
struct MaterialCurve {
  cut::Curve curve;
  double within = 0.0;  // m, 0..kMaxMaterialCoordinate; 0: kCurveTolerance of the sheet's edge length there, as built
  MaterialLine::Side side = MaterialLine::Side::kBoth;  // looking along the curve
};

// The whole border around the hole, or around the outside, that comes nearest to a material point.
struct NearestBorder {
  Eigen::Vector2d point{0.0, 0.0};  // m
};

// The one vertex that is nearest to a material point; of several the smallest id.
struct NearestVertex {
  Eigen::Vector2d point{0.0, 0.0};  // m
};

struct WholeSheet {};

// Vertices of the sheet.
using Region = std::variant<RegionEdge, MaterialBox, std::vector<mesh::VertexId>, MaterialLine, NearestVertex,
                            WholeSheet, MaterialCurve, NearestBorder>;

// A vertex counts as on an edge or a line within this.
inline constexpr double kRegionTolerance = 1.0e-9;  // -, of the larger side of the material bounding box
// A vertex counts as on a curve within this. Lips keep to their curve within 0.02, unless a cut allows more.
inline constexpr double kCurveTolerance = 0.05;  // -, of the edge length there

// Check ranges only; the sheet checks that listed vertices exist. `field`: the path of the list ("pins"), or of the
// region.
Status validate(const std::vector<Region>& regions, const std::string& field);
Status validate(const Region& region, const std::string& field);

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
