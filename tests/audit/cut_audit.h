#pragma once

#include "server/core/cut/cut.h"
#include "tests/audit/mesh_audit.h"

namespace kerf::audit {

// Checks all conditions on an applied cut, from the mesh before, the mesh after and the cut's report:
//   the mesh after has no flaw (find_flaw); the sheet as it was before all cuts keeps its Euler characteristic, and chi
//   changes by the fans and lip edges added; the area of each region, hence the mass, stays the same to 1e-12, and each
//   new triangle lies in old material of its region; existing points, vertices and regions remain, in the same place
//   except for moved_vertices, none of which is fixed or was on a lip; sources are old vertices of one old triangle on
//   the right side of every old lip, with weights that give back rest positions; both lips of a new cut inherit the
//   same bits; slots not in rewritten_triangles are unchanged, and MeshEdit applied to the old opened mesh gives the
//   new one; pieces keep their number or are parts of one that had it; path and lips cover each other (find_path_flaw);
//   the counts and shapes in the report are those of the mesh.
Finding find_cut_flaw(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after, const cut::CutPlan& plan,
                      const cut::CutOutcome& outcome);

// Compares the records of two meshes field by field; returns the first difference.
Finding find_difference(const mesh::TriangleMesh& a, const mesh::TriangleMesh& b);

}  // namespace kerf::audit
