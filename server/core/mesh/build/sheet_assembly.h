#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/mesh/build/mesh_file.h"
#include "server/core/mesh/build/mesh_import.h"
#include "server/core/mesh/ids.h"

namespace kerf::mesh {

// Contents of a mesh file: the input of import_mesh and the positions at the start.
struct ImportedSheet {
  IndexedMesh sheet;                         // rest shape, m; `rest` is empty if material coordinates must be computed
  Eigen::Matrix3Xd world;                    // 3 x V, m, positions of the vertices at the start
  std::vector<std::int32_t> file_positions;  // V, index in the file (from 0) of the position of each vertex
  std::vector<std::int32_t> file_faces;      // T, index in the file (from 0) of the face of each triangle
  std::vector<std::string> notes;            // what was mended, guessed or left out, for people
  bool is_charted = false;                   // material coordinates are the texture coordinates
};

// Makes a sheet of a file, as the reader of `reading.version` does. Vertices that lie at the same place are joined,
// also to a side of another face (join_to_sides()), and polygons split. Faces without area and copies of faces are left
// out; faces are turned as their neighbours are.
//
// Material coordinates are the texture coordinates, if all faces have them and they can be used; a position used with
// two of them becomes two vertices (a seam). Without, they are coordinates in the plane of the positions, namely x and
// y if this is nearly the x-y plane. Without a common plane the rest shape is the curved surface. Vertices are sorted
// by position, then by texture coordinate. Positions without a face are dropped.
//
// Errors have the format's name before the reason, and name faces and vertices with the numbers and lines of the file:
//   NUMBER (a position is not finite or farther than kMaxRestCoordinate from the origin), OBJECT (no object has this
//   name), JOIN (join_m would join most edges), FACE (a face crosses itself), CHART (kFlat only: the texture
//   coordinates have no area, or a face crosses itself there), EMPTY, NOT_PLANAR (kFlat only).
// As of import_mesh(): MESH_NON_MANIFOLD_EDGE, MESH_INCONSISTENT_ORIENTATION.
// `faults`: gets the list, if several faults are the error.
Result<ImportedSheet> assemble(const MeshFile& file, const MeshReading& reading, FaultList* faults = nullptr);

// Assembles the sheet without its chart, and says why.
Result<ImportedSheet> assemble_without_chart(const MeshFile& file, const MeshReading& reading, const std::string& why,
                                             FaultList* faults);

// A sheet made of a mesh file.
struct FileSheet {
  TriangleMesh mesh;
  ImportedSheet imported;
};

// Makes the mesh, too. Texture coordinates that overlap or have no area are not used unless the rest shape is kFlat,
// and a note says so. Vertices are not joined to sides, and a note says so, where the sheet could not be made or its
// texture coordinates not used otherwise. Where the sheet cannot be made and `reading` has no join_m, vertices are
// joined up to 1e-4 of the size apart, and a note says so. Errors: those of assemble(), and of import_mesh() with the
// file's names of faces and vertices. `faults`: as of assemble().
Result<FileSheet> make_sheet(const MeshFile& file, const MeshReading& reading, FaultList* faults = nullptr);

}  // namespace kerf::mesh
