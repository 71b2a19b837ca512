#include "server/sheet/sheet_materials.h"

#include <algorithm>
#include <cstdint>
#include <string>

#include "server/mesh/regions.h"
#include "server/sheet/field_checks.h"
#include "server/sheet/sheet_config.h"

namespace kerf::sheet {

namespace {

std::string path_of(std::size_t entry) {
  return "materials[" + std::to_string(entry) + "]";
}

// The number of a material in the list, to which it is appended where it is new.
std::int32_t number_of(const fem::Material& material, std::vector<fem::Material>& known) {
  const auto at = std::find(known.begin(), known.end(), material);
  if (at != known.end()) return static_cast<std::int32_t>(at - known.begin());
  known.push_back(material);
  return static_cast<std::int32_t>(known.size()) - 1;
}

}  // namespace

Status validate(const std::vector<RegionMaterial>& materials, const fem::Material& own) {
  if (Status s = check_count(materials.size(), kMaxRegions, "regions", "materials"); !s) return s;
  std::vector<fem::Material> different{own};
  std::size_t num_ids = 0;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    if (Status s = validate(materials[i].region, path_of(i) + ".region"); !s) return s;
    if (Status s = fem::validate(materials[i].material, path_of(i) + ".material"); !s) return s;
    number_of(materials[i].material, different);
    const auto* ids = std::get_if<std::vector<mesh::VertexId>>(&materials[i].region);
    if (ids != nullptr) num_ids += ids->size();
  }
  if (Status s = check_count(num_ids, kMaxListedVertices, "vertex ids", "materials"); !s) return s;
  if (different.size() <= kMaxMaterials) return Nothing{};
  return invalid_argument("TOO_MANY_MATERIALS",
                          "the sheet has " + std::to_string(different.size()) +
                              " different materials, its own among them; the limit is " + std::to_string(kMaxMaterials),
                          "materials");
}

Result<std::vector<fem::Material>> assign_materials(SheetConfig& config, mesh::TriangleMesh& mesh) {
  if (config.planar) {
    config.material = fem::without_bending(config.material);
    for (RegionMaterial& part : config.materials) part.material = fem::without_bending(part.material);
  }
  std::vector<fem::Material> given{config.material};
  std::vector<std::int32_t> numbers(static_cast<std::size_t>(mesh.num_triangle_slots()), 0);
  for (std::size_t i = 0; i < config.materials.size(); ++i) {
    const std::string field = path_of(i) + ".region";
    const Result<std::vector<mesh::TriangleId>> found = find_triangles(mesh, config.materials[i].region, field);
    if (!found) return found.error();
    if (found->empty()) {
      return invalid_argument("REGION_EMPTY", field + " has no triangle of the sheet in it", field);
    }
    const std::int32_t number = number_of(config.materials[i].material, given);
    for (const mesh::TriangleId t : *found) numbers[static_cast<std::size_t>(t)] = number;
  }
  std::vector<fem::Material> used;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    std::int32_t& number = numbers[static_cast<std::size_t>(t)];
    number = number_of(given[static_cast<std::size_t>(number)], used);
  }
  if (used.size() > 1) mesh = mesh::with_regions(mesh, numbers);
  return used;
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

}  // namespace kerf::sheet
