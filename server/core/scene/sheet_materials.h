#pragma once

#include <cstdint>
#include <vector>

#include "server/base/result.h"
#include "server/base/state_hash.h"
#include "server/core/fem/element/material_table.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/mesh_source.h"
#include "server/core/scene/sheet_config.h"

namespace kerf::scene {
struct SetMaterial;
}  // namespace kerf::scene

namespace kerf::scene {

using fem::kMaxMaterials;  // most different materials of a sheet, including its own

// Checks the ranges and the number of different materials. `own`: SheetConfig::material.
Status validate(const std::vector<RegionMaterial>& materials, const fem::Material& own);

// Returns the sheet's own material, then the materials of its parts.
std::vector<fem::Material> materials_of(const SheetConfig& config);

// The materials of a sheet and the regions of the mesh that have them. Entry 0 is the sheet's own material, entry 1 + i
// that of SheetConfig::materials[i].
struct SheetMaterials {
  std::vector<fem::Material> entries;
  // For each entry, the region of the mesh that has its material; kNowhere if later entries cover all of it. Entries
  // with the same region had equal materials when the sheet was made.
  std::vector<std::int32_t> region_of;
  std::vector<fem::Material> by_region;  // by region of the mesh, or a single one

  static constexpr std::int32_t kNowhere = -1;
};

// Assigns materials to the triangles of the built mesh. If there are several, the mesh gets one region for each.
// `config` must be valid; if it is planar, its materials lose their bending stiffness. Errors: kInvalidArgument
// REGION_EMPTY (a part has no triangle), and those of place() and find_triangles().
Result<SheetMaterials> assign_materials(SheetConfig& config, BuiltMesh& built);

// Returns `materials` with the material of one entry, or of all entries, replaced. Errors: kInvalidArgument
// UNKNOWN_PART; kFailedPrecondition MATERIAL_SHARED if another entry has the same region.
Result<SheetMaterials> with_material(const SheetMaterials& materials, const SetMaterial& change);

// Adds the bits of all entries, without strain_limit, which has no effect on the motion.
void add_to(StateHash& hash, const SheetMaterials& materials);

// Returns the mass per area of a solid slot, kg/m^2. `materials`: by region of the mesh, or a single one.
double surface_density(const mesh::TriangleMesh& mesh, mesh::TriangleId slot,
                       const std::vector<fem::Material>& materials);

double greatest_thickness(const std::vector<fem::Material>& materials);  // m

}  // namespace kerf::scene
