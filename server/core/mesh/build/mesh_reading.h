#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/mesh/ids.h"

namespace kerf::mesh {

// Versions of the reader of mesh files. Recordings and stores name the one that made their sheet, so that it is made
// again with every bit. The first joins no vertices, mends nothing and splits polygons as fans.
inline constexpr std::int32_t kFirstReader = 1;
inline constexpr std::int32_t kNewestReader = 2;

// Names the axis of the file that points up in the world.
enum class UpAxis {
  kZ,
  kY,  // x, y, z of the file become x, -z, y
  kX,  // x, y, z of the file become -z, y, x
};

// Chooses how a mesh file becomes a sheet. The first reader knows the rest shape alone.
struct MeshReading {
  RestShape rest_shape = RestShape::kAutomatic;
  double unit_m = 1.0;  // m, 1e-9..1e6; metres of a unit of the file, also of its texture coordinates
  UpAxis up_axis = UpAxis::kZ;
  // Joins vertices at most this far apart in space and in the chart, m, 0..1e4; absent: as exactly as the file's
  // numbers are written. 0 keeps equal places apart, as lips of a cut.
  std::optional<double> join_m = std::nullopt;
  bool ignore_texture = false;            // as if the file had no texture coordinates
  std::vector<std::string> objects = {};  // OBJ: names of the objects and groups that are read, at most 64; none: all
  std::int32_t version = kNewestReader;

  friend bool operator==(const MeshReading&, const MeshReading&) = default;
};

}  // namespace kerf::mesh
