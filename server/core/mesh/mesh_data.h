#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "server/core/mesh/edge_lengths.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/lattice.h"
#include "server/core/mesh/predicates.h"
#include "server/core/mesh/rest_surface.h"

namespace kerf::mesh {

// Reasons why flips may not remove an edge. Each triangle stores them for its edges, and both triangles at an edge have
// equal ones. The halves of a split edge inherit them.
using LockBits = std::uint8_t;
inline constexpr LockBits kLockBorder = 1;    // solid on one side, void on the other
inline constexpr LockBits kLockCut = 2;       // two lips lie here: the opened mesh is not connected across the edge
inline constexpr LockBits kLockOriginal = 4;  // an edge of the mesh before the edit that the edit must keep; lives
                                              // within one edit
inline constexpr LockBits kLockRequest = 8;   // on the path of the current cut, whether cut before or not; lives within
                                              // one edit
inline constexpr LockBits kLockFresh = 16;    // first cut by the current edit (set by lock_edge); lives within one edit
inline constexpr LockBits kLocksThatOpen = kLockBorder | kLockCut;
inline constexpr LockBits kLocksOfOneEdit = kLockOriginal | kLockRequest | kLockFresh;

struct PointRecord {
  LatticePoint at;
  TriangleId triangle = kNone;  // one slot with a corner here
  friend bool operator==(const PointRecord&, const PointRecord&) = default;
};

struct VertexRecord {
  PointId point = kNone;
  TriangleId triangle = kNone;  // one solid slot with a corner at this vertex; kNone once its material is removed
  friend bool operator==(const VertexRecord&, const VertexRecord&) = default;
};

// Edge k of a triangle is the one opposite corner k: from corner k+1 to corner k+2 (mod 3).
struct TriangleRecord {
  std::array<PointId, 3> points{kNone, kNone, kNone};         // counter-clockwise in material space
  std::array<TriangleId, 3> neighbours{kNone, kNone, kNone};  // in the welded mesh, across edge k; kNone at the rim of
                                                              // the domain only
  std::array<VertexId, 3> vertices{kNone, kNone, kNone};      // in the opened mesh; kNone in the void
  std::array<LockBits, 3> locks{0, 0, 0};                     // locks of edge k
  // Number of a part of the sheet whose borders flips do not cross. It is the label given at import, >= 0; if the rest
  // shape is curved, the number of the facet. kNone = void.
  std::int32_t region = kNone;
  std::int32_t piece = kNone;  // in [0, num_pieces); kNone in the void
  friend bool operator==(const TriangleRecord&, const TriangleRecord&) = default;
};

// All that a TriangleMesh holds.
struct MeshData {
  Lattice lattice;
  Eigen::AlignedBox2d bounds;                  // m, bounding box of the sheet as built
  EdgeLengths lengths;                         // local edge lengths of the sheet as built
  std::shared_ptr<const RestSurface> surface;  // null: the rest shape is flat, the material plane itself
  std::vector<PointRecord> points;             // by PointId
  std::vector<VertexRecord> vertices;          // by VertexId
  std::vector<TriangleRecord> triangles;       // by TriangleId
  std::int32_t num_solid_triangles = 0;
  std::int32_t num_pieces = 0;
};

inline constexpr int next_corner(int k) {
  return k == 2 ? 0 : k + 1;
}
inline constexpr int previous_corner(int k) {
  return k == 0 ? 2 : k - 1;
}

}  // namespace kerf::mesh
