#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/core/mesh/mesh_editor.h"

namespace kerf::mesh {

// The domain of a lattice without a sheet in it: points 0..3 are its corners, slots 0 and 1 void.
TriangleMesh make_empty_domain(const Lattice& lattice);

// Position along a Hilbert curve of 2^20 x 2^20 cells over the domain: points near each other mostly have near ones.
std::uint64_t hilbert_index(const LatticePoint& p);

// Inserts points, all different and strictly inside the domain, and keeps the triangulation (constrained) Delaunay.
// Uses a biased randomised order (Amenta, Choi, Rote 2003, "Incremental constructions con BRIO"): O(n log n) expected
// for any given order, and deterministic. Returns the id of each point.
std::vector<PointId> insert_delaunay(MeshEditor& editor, std::span<const LatticePoint> points);

}  // namespace kerf::mesh
