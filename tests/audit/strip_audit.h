#pragma once

#include "server/core/cut/cut.h"
#include "tests/audit/mesh_audit.h"

// Checks of cuts that take a strip away, by sampling: they share no code with the cutter.
namespace kerf::audit {

// Checks that exactly the inside of the plan's outline was removed, area by area, up to the deviation. Vertices and
// pieces that are gone must be those reported.
Finding find_strip_flaw(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after, const cut::CutPlan& plan,
                        const cut::CutOutcome& outcome);

// Strews points over the sheet. Those closer to the curve than half the width less the deviation must be void. Those
// farther than half the width and the deviation must be as they were. `seed`: where they are strewn, and `samples`: how
// many; half of them near the curve. Paths with arcs are left to other tests.
Finding find_strewn_flaw(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after, const cut::Curve& curve,
                         const cut::CutPlan& plan, const cut::CutOutcome& outcome, std::uint64_t seed, int samples);

}  // namespace kerf::audit
