#pragma once

#include "server/core/cut/cut.h"
#include "tests/audit/mesh_audit.h"

// Checks cuts with a width, which remove a strip, by sampling. They share no code with the cutter.
namespace kerf::audit {

// Checks by areas that exactly the inside of the plan's outline was removed, up to the reported deviation. Removed
// vertices and pieces must be those reported.
Finding find_strip_flaw(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after, const cut::CutPlan& plan,
                        const cut::CutOutcome& outcome);

// Checks random points of the sheet. Points closer to the curve than half the width minus the deviation must be void.
// Points farther than half the width plus the deviation must be unchanged. `seed`: of the points; `samples`: their
// number, half of them near the curve. Paths with arcs are not checked here.
Finding find_strewn_flaw(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after, const cut::Curve& curve,
                         const cut::CutPlan& plan, const cut::CutOutcome& outcome, std::uint64_t seed, int samples);

}  // namespace kerf::audit
