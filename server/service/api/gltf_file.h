#pragma once

#include <string>

#include "server/core/sheet/snapshot.h"

namespace kerf::api {

// Encodes a binary glTF 2.0 file (.glb) of one mesh, visible from both sides. It has the vertices used by
// triangles, in the order of ids, and the triangles with material, in the order of slots. Attributes of a vertex:
//   POSITION    32-bit floats, m, in glTF's axes: x, z, -y of the world
//   NORMAL      unit; mean over the triangles around the vertex, weighted with their areas
//   TEXCOORD_0  material coordinates, m, unchanged
//   COLOR_0     8 bits per channel, by piece
std::string encode_gltf(const sheet::Snapshot& snapshot);

}  // namespace kerf::api
