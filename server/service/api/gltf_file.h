#pragma once

#include <string>

#include "server/core/sheet/snapshot.h"

namespace kerf::api {

// Encodes a binary glTF 2.0 file (.glb) of one mesh, visible from both sides. Vertices used by a triangle follow in the
// order of their ids; triangles with material follow in the order of the slots. Attributes of a vertex:
//   POSITION    32-bit floats, m, in glTF's axes: x, z, -y of the world
//   NORMAL      unit; mean over the triangles around the vertex, weighted with their areas
//   TEXCOORD_0  material coordinates, m, unchanged
//   COLOR_0     8 bits per channel, by piece
std::string encode_gltf(const sheet::Snapshot& snapshot);

}  // namespace kerf::api
