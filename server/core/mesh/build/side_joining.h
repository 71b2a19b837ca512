#pragma once

#include <string>
#include <vector>

#include "server/core/mesh/build/face_repair.h"
#include "server/core/mesh/build/file_places.h"
#include "server/core/mesh/build/mesh_file.h"

namespace kerf::mesh {

// Makes vertices that lie within a side of another polygon corners of that polygon, in order along the side. The side
// must be a border of its polygon, and the vertex an end of another such side. They meet as closely as vertices that
// are joined: in space, and in the chart if there is one. Split polygons begin at such a corner. Notes tell how many
// vertices there are and where the first is. Nothing changes if places are not joined. Nor does it if a polygon would
// have more than kMaxFaceCorners, or if too many faces lie over each other: a note says so.
void join_to_sides(const MeshFile& file, const FilePlaces& places, FacePolygons& faces,
                   std::vector<std::string>& notes);

}  // namespace kerf::mesh
