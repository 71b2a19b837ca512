#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/mesh/build/mesh_import.h"

namespace kerf::mesh {

inline constexpr std::size_t kMaxFaceCorners = 64;

// Contents of a mesh file: the input of import_mesh and the positions at the start.
struct ImportedSheet {
  IndexedMesh sheet;                         // rest shape, m; `rest` is empty if material coordinates must be computed
  Eigen::Matrix3Xd world;                    // 3 x V, m, positions of the vertices at the start
  std::vector<std::int32_t> file_positions;  // V, index in the file (from 0) of the position of each vertex
};

// Collects positions, texture coordinates and faces from a mesh file of any format, and makes a sheet of them. Errors
// are kInvalidArgument without a field, since only the reader of the file knows the place. The reader prefixes the
// reason with the format's name, as in "OBJ_FACE".
class FaceList {
 public:
  // Index of a position, and index of a texture coordinate or kNone.
  using Corner = std::pair<std::int32_t, std::int32_t>;

  // `first_number`: number of the file's first position in messages, 0 or 1.
  explicit FaceList(int first_number) : first_number_(first_number) {}

  // Adds a position, m. Errors: NUMBER if a coordinate is not finite or exceeds kMaxRestCoordinate in magnitude,
  // TOO_LARGE beyond kMaxVertices positions.
  Status add_position(const Eigen::Vector3d& position);
  // Adds a texture coordinate, m. Errors: NUMBER if it is not finite, TOO_LARGE beyond 4 kMaxVertices of them.
  Status add_texture(const Eigen::Vector2d& texture);
  // Adds a polygon of 3 to kMaxFaceCorners corners, split into a fan of triangles. Its indices must be valid when
  // assemble() is called. Errors: FACE (number of corners), MIXED_TEXTURE (some corners of the file have a texture
  // coordinate, others do not), TOO_LARGE (more than 2 kMaxVertices triangles).
  Status add_face(std::span<const Corner> corners);

  [[nodiscard]] std::size_t num_positions() const { return positions_.size(); }
  [[nodiscard]] std::size_t num_textures() const { return textures_.size(); }

  // Makes the sheet. Material coordinates are the texture coordinates, if the faces have any; a position used with two
  // of them becomes two vertices (a seam). Without texture coordinates they are coordinates in the plane of the
  // positions, namely x and y if this is nearly the x-y plane. Without a common plane the rest shape is the curved
  // surface. Vertices are sorted by position, then by texture coordinate. Positions without a face are dropped. Errors:
  // EMPTY, NOT_PLANAR (kFlat only).
  [[nodiscard]] Result<ImportedSheet> assemble(RestShape rest_shape) const;

 private:
  [[nodiscard]] Status flatten(ImportedSheet& imported) const;

  int first_number_;
  std::vector<Eigen::Vector3d> positions_;
  std::vector<Eigen::Vector2d> textures_;
  std::vector<std::array<Corner, 3>> triangles_;
  bool has_texture_ = false;
};

}  // namespace kerf::mesh
