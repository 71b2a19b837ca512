#pragma once

#include <vector>

#include "server/core/mesh/ids.h"
#include "server/core/mesh/triangle_mesh.h"

// The same sheet with other numbers, as memory follows them.
namespace kerf::bench {

struct Numbering {
  std::vector<mesh::VertexId> vertices;  // the new one of each vertex
  std::vector<mesh::TriangleId> slots;   // the new one of each slot, void ones included
};

enum class Order {
  kSame,         // as it is
  kTriangles,    // triangles by place, along a Z curve
  kNewVertices,  // and so are vertices that cuts have added, behind those of the grid
  kRows,         // all vertices by rows of the grid, triangles by their lowest vertex
  kCurve,        // all vertices by place, along a Z curve, triangles by their lowest vertex
};

// Numbers a unit square that had side x side vertices before it was cut.
Numbering number(const mesh::TriangleMesh& mesh, int side, Order order);

// A mesh of its own, as one imported in that order would be.
mesh::TriangleMesh renumbered(const mesh::TriangleMesh& mesh, const Numbering& numbering);

}  // namespace kerf::bench
