#include "server/service/wire/component_codec.h"

#include <cstddef>
#include <utility>

#include "server/core/scene/components.h"
#include "server/service/wire/material_codec.h"
#include "server/service/wire/mesh_source_codec.h"
#include "server/service/wire/region_codec.h"

namespace kerf::wire {
namespace {

Status decode_own_materials(const v1::Component& component, const std::string& path, scene::SheetConfig& config) {
  if (component.has_material()) {
    const std::string field = path + ".material";
    KERF_TRY_ASSIGN(const fem::Material material, decode_material(component.material(), field));
    config.materials.push_back({scene::Region(scene::WholeSheet{}, component.name()), material, field});
  }
  for (int i = 0; i < component.materials_size(); ++i) {
    const std::string field = path + ".materials[" + std::to_string(i) + "]";
    KERF_TRY_ASSIGN(scene::RegionMaterial part, decode_part(component.materials(i), field));
    if (!part.region.component.empty() && part.region.component != component.name()) {
      return invalid_argument("CHOICE_AMBIGUOUS",
                              field + ".region.component is \"" + part.region.component +
                                  "\", but the region is one of " + component.name() + ": leave it out",
                              field + ".region.component");
    }
    part.region.component = component.name();
    part.given_as = field;
    config.materials.push_back(std::move(part));
  }
  return Nothing{};
}

}  // namespace

Status decode_components(v1::Scene& scene, const FileReader& read_file, scene::SheetConfig& config) {
  const bool has_mesh = scene.mesh_case() != v1::Scene::MESH_NOT_SET;
  if (has_mesh || scene.has_placement()) {
    const std::string field = has_mesh ? "mesh" : "placement";
    return invalid_argument("CHOICE_AMBIGUOUS",
                            field + " and components cannot both be given: each component has its own", field);
  }
  for (int i = 0; i < scene.components_size(); ++i) {
    v1::Component& message = *scene.mutable_components(i);
    scene::Component component;
    component.name = message.name();
    Result<scene::MeshSource> mesh = decode_mesh_source(message, read_file);
    if (!mesh.ok()) return scene::in_component(mesh.error(), static_cast<std::size_t>(i), message.name());
    component.mesh = std::move(mesh).value();
    if (message.has_placement()) component.placement = decode_placement(message.placement());
    if (message.has_offset()) component.offset = decode_vector(message.offset());
    config.components.push_back(std::move(component));
    KERF_TRY(decode_own_materials(message, "components[" + std::to_string(i) + "]", config));
  }
  return Nothing{};
}

v1::Component encode_component(const scene::Component& component) {
  v1::Component message;
  message.set_name(component.name);
  encode_mesh_source(component.mesh, message);
  if (component.placement) encode_placement(*component.placement, *message.mutable_placement());
  if (component.offset) encode_vector(*component.offset, *message.mutable_offset());
  return message;
}

v1::SheetComponent encode_component_place(const scene::ComponentPlace& place) {
  v1::SheetComponent message;
  message.set_name(place.name);
  encode_vector(place.offset, *message.mutable_offset());
  encode_vector(Eigen::Vector2d(place.extent.min()), *message.mutable_extent()->mutable_min());
  encode_vector(Eigen::Vector2d(place.extent.max()), *message.mutable_extent()->mutable_max());
  message.set_first_vertex(place.first_vertex);
  message.set_num_vertices(place.num_vertices);
  return message;
}

Result<scene::RegionMaterial> decode_part(const v1::RegionMaterial& part, const std::string& path) {
  KERF_TRY_ASSIGN(scene::Region region, decode_region(part.region(), path + ".region"));
  KERF_TRY_ASSIGN(const fem::Material material, decode_material(part.material(), path + ".material"));
  return scene::RegionMaterial{std::move(region), material};
}

scene::Placement decode_placement(const v1::Placement& message) {
  scene::Placement placement;
  if (message.has_origin()) placement.origin = decode_vector(message.origin());
  if (message.has_x_axis()) placement.x_axis = decode_vector(message.x_axis());
  if (message.has_y_axis()) placement.y_axis = decode_vector(message.y_axis());
  return placement;
}

void encode_placement(const scene::Placement& placement, v1::Placement& message) {
  encode_vector(placement.origin, *message.mutable_origin());
  encode_vector(placement.x_axis, *message.mutable_x_axis());
  encode_vector(placement.y_axis, *message.mutable_y_axis());
}

}  // namespace kerf::wire
