#pragma once

#include <string>

#include "server/core/sheet/snapshot.h"

namespace kerf::api {

// A binary glTF 2.0 file (.glb) of one mesh, visible from both sides: of each vertex that a triangle uses, in the order
// of their ids, position (32-bit floats, m, in glTF's axes: x, z, -y of the world), normal (unit, of the triangles
// around it, weighted with their areas), TEXCOORD_0 (material coordinates, m, as they are) and COLOR_0 (8-bit, by its
// piece), and the triangles with material in the order of the slots.
std::string encode_gltf(const sheet::Snapshot& snapshot);

}  // namespace kerf::api
