#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/core/mesh/mesh_editor.h"

namespace kerf::mesh {

// Makes a mesh of the empty domain of a lattice. Points 0..3 are the corners of the domain, slots 0 and 1 are void.
TriangleMesh make_empty_domain(const Lattice& lattice);

// Returns the position of p along a Hilbert curve over the domain, in 2^20 x 2^20 cells. Points near each other mostly
// have near positions.
std::uint64_t hilbert_index(const LatticePoint& p);

// Inserts points and keeps the triangulation (constrained) Delaunay. The points are different and strictly inside the
// domain. Uses a biased randomised order (Amenta, Choi, Rote 2003, "Incremental constructions con BRIO"): O(n log n)
// expected for any given order, and deterministic. Returns the id of each point.
std::vector<PointId> insert_delaunay(MeshEditor& editor, std::span<const LatticePoint> points);

}  // namespace kerf::mesh
