#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "server/core/mesh/build/mesh_file.h"
#include "server/core/mesh/ids.h"

namespace kerf::mesh {

// Positions and texture coordinates of a file as a reading wants them, and which of them are the same.
struct FilePlaces {
  std::vector<Eigen::Vector3d> positions;    // m, in the world; of each position of the file
  std::vector<Eigen::Vector2d> textures;     // m; empty if they are not used
  std::vector<std::int32_t> first_position;  // the lowest position at the same place
  std::vector<std::int32_t> first_texture;   // empty if textures are not used
  bool is_joined = false;                    // false: places count as different, even equal ones
  double position_tolerance = 0.0;           // m, >= 0; distance of positions that are joined
  double texture_tolerance = 0.0;            // m, >= 0; the same for textures

  // Returns the position in space of a corner, and its place in the chart with z = 0.
  [[nodiscard]] const Eigen::Vector3d& at(const MeshFile::Corner& corner) const { return positions[corner.first]; }
  [[nodiscard]] Eigen::Vector3d in_chart(const MeshFile::Corner& corner) const {
    return {textures[corner.second].x(), textures[corner.second].y(), 0.0};
  }
};

// Converts a file to metres and to the axes of the world, and finds places that are the same. `faces`: those that are
// read. Faults: NUMBER (a vertex of a face is not finite, or beyond kMaxRestCoordinate), JOIN (join_m is longer than
// most edges). Notes tell of vertices that no face uses.
FilePlaces place_file(const MeshFile& file, const MeshReading& reading, std::span<const std::int32_t> faces,
                      bool is_charted, std::vector<std::string>& notes, FaultList& faults);

// Returns the corners in order along the line on which all of them lie, by index; empty if they span an area.
std::vector<std::int32_t> order_on_line(std::span<const Eigen::Vector3d> corners);

// Says if a sheet is so large or small that the file may have another unit. `world`: 3 x V, m.
void note_size(const Eigen::Matrix3Xd& world, std::vector<std::string>& notes);

// Returns the median, 0 if there are no lengths. Reorders them.
double median(std::vector<double>& lengths);

}  // namespace kerf::mesh
