#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "server/core/cut/curve.h"
#include "server/service/dxf/entity.h"

namespace kerf::dxf {

// Tells how the plane of an entity's coordinates lies.
enum class Plane {
  kUpright,   // The drawing's own, or parallel to it.
  kMirrored,  // Seen from below: x points the other way.
  kOther,     // Not parallel to the drawing.
};
Plane plane_of(const Entity& entity);

// True for entities whose coordinates are in the plane of their extrusion, rather than in the drawing's.
bool has_own_plane(std::string_view type);

// Returns the outline of an entity in its own coordinates; nothing if the entity is of no kind that has one. The
// outline is empty if the entity is only a point. `vertices`: those that belong to a POLYLINE.
std::optional<std::vector<cut::Subpath>> outline_of(const Entity& entity, const std::vector<Entity>& vertices);

}  // namespace kerf::dxf
