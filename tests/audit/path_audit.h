#pragma once

#include "server/core/cut/cut.h"
#include "tests/audit/mesh_audit.h"

namespace kerf::audit {

// Checks that path and lips cover each other, by lengths and not by samples. Every stretch of the plan's strokes inside
// the sheet lies within the reported deviation of a lip or of the border. Every new lip lies within this deviation of
// the strokes. Every old lip and border edge still exists, unless the cut removes material. Also checks that the
// report's crossed_triangles is the number of old triangles that the strokes cross, either with or without triangles
// that they only graze.
Finding find_path_flaw(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after, const cut::CutPlan& plan,
                       const cut::CutReport& report);

// Runs only the first check of find_path_flaw(): returns a stretch of the strokes inside the sheet that no lip or
// border is near.
Finding find_uncovered_path(const mesh::TriangleMesh& mesh, const cut::CutPlan& plan, const cut::CutReport& report);

// Checks points of the curve itself, `samples` per piece. Those inside the sheet must lie within the reported deviation
// of a lip or of the border. Lines of a path that are a single point are left out. If the report has merged segments,
// lines no larger than `dust_m` (m) are left out too.
Finding find_curve_flaw(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after, const cut::Curve& curve,
                        const cut::CutReport& report, int samples, double dust_m);

// Returns the plan's tolerance, m, where the sheet as built has its longest edges.
double largest_tolerance(const mesh::TriangleMesh& mesh, const cut::CutPlan& plan);

// Returns the plan's snap distance, m, where the sheet as built has its longest edges.
double largest_snap(const mesh::TriangleMesh& mesh, const cut::CutPlan& plan);

}  // namespace kerf::audit
