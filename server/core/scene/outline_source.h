#pragma once

#include <cstdint>

#include "server/base/result.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/sheet_config.h"

namespace kerf::scene {

// Checks an outline without flattening its curves. Errors: those of cut::validate() and of field_checks.h,
// TOO_MANY; fields as in kerf.v1.Scene ("outline.holes[2].circle.radius_m").
Status validate(const OutlineSource& outline);

// Flattens the curves of a valid outline finely, then meshes it by mesh::mesh_outline(). Border vertices are off their
// curve by at most 2e-5 of the shortest requested edge length, or 1e-9 of the larger side of the border. Nearly all are
// on it up to rounding. Errors: those of mesh::mesh_outline(), kInvalidArgument OUTLINE_OPEN (a line does not end where
// it began), OUTLINE_BORDER (the border has no line), OUTLINE_OUT_OF_RANGE (a curve reaches beyond
// kMaxMaterialCoordinate); kResourceExhausted OUTLINE_CURVES (more than kMaxOutlineChords chords).
Result<mesh::TriangleMesh> mesh_outline(const OutlineSource& outline, std::int32_t max_vertices);

}  // namespace kerf::scene
