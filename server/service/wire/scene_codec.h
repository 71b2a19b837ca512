#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "kerf/v1/scene.pb.h"
#include "server/base/result.h"
#include "server/core/scene/sheet_config.h"
#include "server/service/wire/geometry_codec.h"

// Converts kerf.v1.Scene and its parts to and from the types of the sheet. Errors are kInvalidArgument with the field
// path as in scene.proto, from the message given ("grid.columns", "pins[2].box.min.x",
// "commands[0].command.cut.curve"). They cover faults of the message alone (no choice made, an array of odd length, an
// unknown preset) and all that scene::validate() refuses.
namespace kerf::wire {

// Decodes a scene, with the defaults that scene.proto documents. Without a reader ObjMesh.file, PlyMesh.file and
// Svg.file are refused (OBJ_FILE_REFUSED, PLY_FILE_REFUSED, SVG_FILE_REFUSED), as required for network requests. Text
// or data of a mesh is moved out of the scene: pass one that is not needed any more.
Result<scene::SheetConfig> decode_scene(v1::Scene scene, const FileReader& read_file = {});

// Encodes the complete scene, with every number: decode_scene(encode_scene(c)) equals c bit for bit, for every c made
// by decode_scene(). Only the fields that errors name for materials of components differ.
v1::Scene encode_scene(const scene::SheetConfig& config);

inline constexpr std::size_t kMaxSceneFileBytes = std::size_t{128} << 20;  // An OBJ text of 64 MiB, escaped.

// Decodes a scene file in JSON. Errors of from_json() and decode_scene().
Result<scene::SheetConfig> decode_scene_file(std::string_view json, const FileReader& read_file);

// Holds the settings of a scene in force now.
struct SettingsInForce {
  const scene::SheetConfig& config;          // As created.
  std::span<const fem::Material> materials;  // The sheet's own, then those of config.materials.
  Eigen::Vector3d gravity;                   // m/s^2
  scene::Wind wind;
  scene::SelfContact self_contact;
};

// Encodes kerf.v1.Sheet.scene: a scene without mesh, pins and commands.
v1::Scene encode_settings(const SettingsInForce& settings);

v1::Collider encode_collider(const contact::Collider& collider);

}  // namespace kerf::wire
