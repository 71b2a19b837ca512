#pragma once

#include <string>

#include "kerf/v1/scene.pb.h"
#include "kerf/v1/sheets.pb.h"
#include "server/base/result.h"
#include "server/core/scene/sheet_config.h"
#include "server/service/wire/geometry_codec.h"

// Converts the components of a scene and what each has of its own: mesh, placement, materials.
namespace kerf::wire {

// Decodes Scene.components and appends their materials to those of `config`, as regions of the components. Moves text
// and data of meshes out of the scene. Errors, which name the component: those of decode_mesh_source() and
// decode_part(); CHOICE_AMBIGUOUS if the scene has a mesh or a placement, or a material of a component names another.
Status decode_components(v1::Scene& scene, const FileReader& read_file, scene::SheetConfig& config);
// Encodes a component without its materials, which SheetConfig::materials has.
v1::Component encode_component(const scene::Component& component);

v1::SheetComponent encode_component_place(const scene::ComponentPlace& place);

// Decodes a part of another material; `path` names it ("materials[1]").
Result<scene::RegionMaterial> decode_part(const v1::RegionMaterial& part, const std::string& path);

// Decodes a placement with the defaults that scene.proto documents; checks no ranges.
scene::Placement decode_placement(const v1::Placement& message);
void encode_placement(const scene::Placement& placement, v1::Placement& message);

}  // namespace kerf::wire
