#pragma once

#include <cstdint>

#include "server/base/result.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/sheet_config.h"

namespace kerf::sheet {

// Checks an outline without flattening its curves. Errors: those of cut::validate() and of field_checks.h,
// TOO_MANY; fields as in kerf.v1.Scene ("outline.holes[2].circle.radius_m").
Status validate(const OutlineSource& outline);

// Flattens the curves of a valid outline finely, then meshes it by mesh::mesh_outline(). A vertex is off its curve by
// at most 2e-5 of the shortest requested edge length, or 1e-9 of the larger side of the border. It is nearly always on
// it to rounding. Errors: those of mesh::mesh_outline(), OUTLINE_OPEN (a line that does not end where it began),
// OUTLINE_BORDER (a border of several lines), OUTLINE_OUT_OF_RANGE (kInvalidArgument; a curve reaches beyond
// kMaxMaterialCoordinate), OUTLINE_CURVES (kResourceExhausted; beyond kMaxOutlineChords).
Result<mesh::TriangleMesh> mesh_outline(const OutlineSource& outline, std::int32_t max_vertices);

}  // namespace kerf::sheet
