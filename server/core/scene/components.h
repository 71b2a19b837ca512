#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "server/base/result.h"
#include "server/core/cut/cut.h"
#include "server/core/scene/command.h"
#include "server/core/scene/mesh_source.h"
#include "server/core/scene/sheet_config.h"

// Components of a scene: their meshes become one, and their coordinates become those of the scene's material plane.
namespace kerf::scene {

// Returns an error of a part of a component as that of component number `index`: its field and its message name it.
Error in_component(Error error, std::size_t index, const std::string& name);

// Returns the error kInvalidArgument COMPONENT_UNKNOWN, which lists the names. `field`: path of the name.
Error unknown_component(const std::string& name, const std::vector<std::string>& names, const std::string& field);

// Builds the meshes of all components and joins them. A component that is flat joins curved ones as a flat surface.
// Errors, besides those of build_source(): kInvalidArgument COMPONENTS_OVERLAP, OUT_OF_RANGE (a component lies beyond
// kMaxMaterialCoordinate); kResourceExhausted TOO_MANY_VERTICES. `config` must be valid and have components.
Result<BuiltMesh> build_components(const SheetConfig& config);

// A region in the scene's material plane.
struct PlacedRegion {
  RegionShape shape;                       // m; listed vertices are ids of the sheet
  const ComponentPlace* within = nullptr;  // the component that it is a part of; null: the whole sheet
};

// Moves a region into the scene's plane. The result refers to `places`. Errors: kInvalidArgument COMPONENT_UNKNOWN,
// UNKNOWN_VERTEX (a listed vertex is none of the component as built). `field`: path of the region.
Result<PlacedRegion> place(const Region& region, std::span<const ComponentPlace> places, const std::string& field);

// Sets the curve, the options, the view and the room of a request from a cut. Error: kInvalidArgument
// COMPONENT_UNKNOWN.
Status place(const Cut& cut, std::span<const ComponentPlace> places, cut::CutRequest& request);

}  // namespace kerf::scene
