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

// Contents of a mesh file: input of import_mesh, and the state to start from.
struct ImportedSheet {
  IndexedMesh sheet;                         // rest shape, m, `rest` empty where material coordinates are to be made
  Eigen::Matrix3Xd world;                    // 3 x V, m, where the vertices start
  std::vector<std::int32_t> file_positions;  // V, the position in the file (from 0) each vertex comes from
};

// Positions, texture coordinates and faces as mesh files of every format have them, and the sheet they make. Errors are
// kInvalidArgument with a reason that the format's name goes before ("OBJ_FACE"), without a field: only the file's
// reader knows the place.
class FaceList {
 public:
  // Index of a position and of a texture coordinate, or kNone.
  using Corner = std::pair<std::int32_t, std::int32_t>;

  // first_number: what the file's first position is called in messages, 0 or 1.
  explicit FaceList(int first_number) : first_number_(first_number) {}

  // Adds a position, m. Errors: NUMBER if a coordinate is not finite or exceeds kMaxRestCoordinate in magnitude,
  // TOO_LARGE beyond kMaxVertices positions.
  Status add_position(const Eigen::Vector3d& position);
  // Adds a texture coordinate, m. Errors: NUMBER if it is not finite, TOO_LARGE beyond 4 kMaxVertices of them.
  Status add_texture(const Eigen::Vector2d& texture);
  // A polygon of 3 to kMaxFaceCorners corners, split as a fan; all corners have a texture coordinate or none has: FACE,
  // MIXED_TEXTURE, TOO_LARGE (2 kMaxVertices triangles). Its indices are those of positions and texture coordinates
  // added before assemble().
  Status add_face(std::span<const Corner> corners);

  [[nodiscard]] std::size_t num_positions() const { return positions_.size(); }
  [[nodiscard]] std::size_t num_textures() const { return textures_.size(); }

  // Texture coordinates, where there are some, are the material coordinates, and a position used with two of them
  // becomes two vertices (a seam). Else the plane of the positions gives them; a plane close to x-y keeps x, y as they
  // are. Vertices are numbered in the order of their positions, then of their texture coordinates; positions without a
  // face are dropped. Errors: EMPTY, NOT_PLANAR (kFlat only).
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
