#pragma once

#include <vector>

#include "server/base/result.h"
#include "server/fem/material_table.h"
#include "server/mesh/triangle_mesh.h"
#include "server/sheet/region.h"

namespace kerf::sheet {

struct SheetConfig;

using fem::kMaxMaterials;  // different ones of a sheet, its own among them

// A part of the sheet of another material.
struct RegionMaterial {
  Region region;  // see find_triangles
  fem::Material material;
};

// Ranges, and the number of different materials.
Status validate(const std::vector<RegionMaterial>& materials, const fem::Material& own);

// The materials that triangles of the mesh have, each once; their numbers become the regions of the mesh, where there
// are several. `config` must be valid; bending of a planar sheet is switched off in it. Errors: kInvalidArgument
// REGION_EMPTY and those of find_triangles.
Result<std::vector<fem::Material>> assign_materials(SheetConfig& config, mesh::TriangleMesh& mesh);

// kg/m^2, of a solid slot of a mesh with these materials.
double surface_density(const mesh::TriangleMesh& mesh, mesh::TriangleId slot,
                       const std::vector<fem::Material>& materials);

double greatest_thickness(const std::vector<fem::Material>& materials);  // m

}  // namespace kerf::sheet
