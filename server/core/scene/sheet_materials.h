#pragma once

#include <cstdint>
#include <vector>

#include "server/base/result.h"
#include "server/base/state_hash.h"
#include "server/core/fem/element/material_table.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/sheet_config.h"

namespace kerf::sheet {

struct SetMaterial;

using fem::kMaxMaterials;  // different ones of a sheet, its own among them

// Ranges, and the number of different materials.
Status validate(const std::vector<RegionMaterial>& materials, const fem::Material& own);

// Returns the sheet's own material, then the materials of its parts.
std::vector<fem::Material> materials_of(const SheetConfig& config);

// The materials of a sheet and their places. Entry 0 is the sheet's own, entry 1 + i that of SheetConfig::materials[i].
struct SheetMaterials {
  std::vector<fem::Material> entries;
  // For each entry the region of the mesh that has it; kNowhere where later ones cover it. Entries of one region had
  // equal materials when the sheet was made.
  std::vector<std::int32_t> region_of;
  std::vector<fem::Material> by_region;  // of the mesh, or one

  static constexpr std::int32_t kNowhere = -1;
};

// Assigns materials to the triangles of the mesh; if there are several, they become the regions of the mesh. `config`
// must be valid; bending of a planar sheet is switched off in it. Errors: kInvalidArgument REGION_EMPTY and those of
// find_triangles.
Result<SheetMaterials> assign_materials(SheetConfig& config, mesh::TriangleMesh& mesh);

// Returns the same regions with another material in one entry, or in all of them. Errors: kInvalidArgument
// UNKNOWN_PART; kFailedPrecondition MATERIAL_SHARED where another entry has the same region.
Result<SheetMaterials> with_material(const SheetMaterials& materials, const SetMaterial& change);

// Hashes the entries, bit for bit.
void add_to(StateHash& hash, const SheetMaterials& materials);

// kg/m^2, of a solid slot of a mesh with these materials.
double surface_density(const mesh::TriangleMesh& mesh, mesh::TriangleId slot,
                       const std::vector<fem::Material>& materials);

double greatest_thickness(const std::vector<fem::Material>& materials);  // m

}  // namespace kerf::sheet
