#include "server/core/scene/sheet_materials.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include "server/core/mesh/regions.h"
#include "server/core/scene/command.h"
#include "server/core/scene/field_checks.h"
#include "server/core/scene/region.h"
#include "server/core/scene/sheet_config.h"

namespace kerf::scene {

namespace {

std::string path_of(const std::vector<RegionMaterial>& materials, std::size_t entry) {
  const std::string& given_as = materials[entry].given_as;
  return given_as.empty() ? indexed("materials", entry) : given_as;
}

// Returns the path of an entry's material: the entry itself, if a component has it as its own.
std::string material_path(const std::vector<RegionMaterial>& materials, std::size_t entry) {
  const std::string path = path_of(materials, entry);
  return path.ends_with(']') ? path + ".material" : path;
}

// Returns the name of an entry of SheetMaterials, for messages.
std::string part_name(std::size_t entry) {
  return entry == 0 ? "the sheet's own material" : "part " + std::to_string(entry - 1);
}

// Returns the index of a material in `known`. Appends it if it is not there.
std::int32_t number_of(const fem::Material& material, std::vector<fem::Material>& known) {
  const auto at = std::find(known.begin(), known.end(), material);
  if (at != known.end()) return static_cast<std::int32_t>(at - known.begin());
  known.push_back(material);
  return static_cast<std::int32_t>(known.size()) - 1;
}

}  // namespace

Status validate(const std::vector<RegionMaterial>& materials, const fem::Material& own) {
  KERF_TRY(check_count(materials.size(), kMaxRegions, "regions", "materials"));
  std::vector<fem::Material> different{own};
  std::size_t num_ids = 0;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    KERF_TRY(validate(materials[i].region, path_of(materials, i) + ".region"));
    KERF_TRY(fem::validate(materials[i].material, material_path(materials, i)));
    number_of(materials[i].material, different);
    const auto* ids = std::get_if<std::vector<mesh::VertexId>>(&materials[i].region.shape);
    if (ids != nullptr) num_ids += ids->size();
  }
  KERF_TRY(check_count(num_ids, kMaxListedVertices, "vertex ids", "materials"));
  if (different.size() <= kMaxMaterials) return Nothing{};
  return invalid_argument("TOO_MANY_MATERIALS",
                          "the sheet has " + std::to_string(different.size()) +
                              " different materials, including its own; the limit is " + std::to_string(kMaxMaterials),
                          "materials");
}

std::vector<fem::Material> materials_of(const SheetConfig& config) {
  std::vector<fem::Material> materials{config.material};
  for (const RegionMaterial& part : config.materials) materials.push_back(part.material);
  return materials;
}

Result<SheetMaterials> assign_materials(SheetConfig& config, BuiltMesh& built) {
  mesh::TriangleMesh& mesh = built.mesh;
  if (config.planar) {
    config.material = fem::without_bending(config.material);
    for (RegionMaterial& part : config.materials) part.material = fem::without_bending(part.material);
  }
  std::vector<fem::Material> given{config.material};
  SheetMaterials assigned;
  assigned.entries = materials_of(config);
  assigned.region_of = {0};  // indices into `given` at first
  std::vector<std::int32_t> numbers(static_cast<std::size_t>(mesh.num_triangle_slots()), 0);
  for (std::size_t i = 0; i < config.materials.size(); ++i) {
    const std::string field = path_of(config.materials, i) + ".region";
    KERF_TRY_ASSIGN(const PlacedRegion region, place(config.materials[i].region, built.components, field));
    KERF_TRY_ASSIGN(const std::vector<mesh::TriangleId> found, find_triangles(mesh, region, field));
    if (found.empty()) {
      return invalid_argument("REGION_EMPTY", field + " contains no triangle of the sheet", field);
    }
    const std::int32_t number = number_of(config.materials[i].material, given);
    for (const mesh::TriangleId t : found) numbers[static_cast<std::size_t>(t)] = number;
    assigned.region_of.push_back(number);
  }
  std::vector<fem::Material>& used = assigned.by_region;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    std::int32_t& number = numbers[static_cast<std::size_t>(t)];
    number = number_of(given[static_cast<std::size_t>(number)], used);
  }
  if (used.size() > 1) mesh = mesh::with_regions(mesh, numbers);
  for (std::int32_t& region : assigned.region_of) {
    const auto at = std::find(used.begin(), used.end(), given[static_cast<std::size_t>(region)]);
    region = at == used.end() ? SheetMaterials::kNowhere : static_cast<std::int32_t>(at - used.begin());
  }
  return assigned;
}

Result<SheetMaterials> with_material(const SheetMaterials& materials, const SetMaterial& change) {
  SheetMaterials changed = materials;
  if (!change.part) {
    std::fill(changed.entries.begin(), changed.entries.end(), change.material);
    std::fill(changed.by_region.begin(), changed.by_region.end(), change.material);
    return changed;
  }
  const auto entry = static_cast<std::size_t>(*change.part - SetMaterial::kOwn);
  if (entry >= changed.entries.size()) {
    return invalid_argument("UNKNOWN_PART",
                            "set_material.part is " + std::to_string(*change.part) + "; the sheet has " +
                                std::to_string(changed.entries.size() - 1) +
                                " parts, numbered from 0; -1 is its own material",
                            "set_material.part");
  }
  changed.entries[entry] = change.material;
  const std::int32_t region = changed.region_of[entry];
  if (region == SheetMaterials::kNowhere) return changed;
  for (std::size_t other = 0; other < changed.entries.size(); ++other) {
    if (other == entry || changed.region_of[other] != region) continue;
    return failed_precondition(
        "MATERIAL_SHARED",
        part_name(entry) + " and " + part_name(other) +
            " had the same material when the sheet was created and cannot be set apart since; leave out the part to "
            "set the whole sheet, or create the sheet with different materials",
        "set_material.part");
  }
  changed.by_region[static_cast<std::size_t>(region)] = change.material;
  return changed;
}

void add_to(StateHash& hash, const SheetMaterials& materials) {
  static_assert(sizeof(fem::Material) == 11 * sizeof(double) + 4 * sizeof(std::optional<double>),
                "add all of it but strain_limit, which moves nothing");
  for (const fem::Material& m : materials.entries) {
    for (const double value :
         {m.youngs_modulus_1, m.youngs_modulus_2, m.poissons_ratio_12, m.shear_modulus, m.direction, m.thickness,
          m.density, m.bending_scale, m.mass_damping, m.stiffness_damping}) {
      hash.add(value);
    }
    for (const std::optional<double>& value :
         {m.bending_stiffness_1, m.bending_stiffness_2, m.bending_coupling, m.twisting_stiffness}) {
      hash.add(value.has_value());
      hash.add(value.value_or(0.0));
    }
  }
}

double surface_density(const mesh::TriangleMesh& mesh, mesh::TriangleId slot,
                       const std::vector<fem::Material>& materials) {
  const auto number = materials.size() == 1 ? std::size_t{0} : static_cast<std::size_t>(mesh.region(slot));
  return materials[number].density * materials[number].thickness;
}

double greatest_thickness(const std::vector<fem::Material>& materials) {
  double thickness = 0.0;
  for (const fem::Material& material : materials) thickness = std::max(thickness, material.thickness);
  return thickness;
}

}  // namespace kerf::scene
