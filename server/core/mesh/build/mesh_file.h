#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/mesh/build/number_precision.h"

namespace kerf::mesh {

inline constexpr std::size_t kMaxFaceCorners = 20'000;
inline constexpr std::size_t kMaxShownFaults = 5;  // faults that an error lists

// Text of a comment in meshes that Kerf exports. Vertices at one place are lips of a cut there, and stay apart.
inline constexpr std::string_view kKerfComment = "Kerf:";

// Contents of a mesh file of any format, as they stand there: units, axes and numbers are those of the file.
struct MeshFile {
  // Index of a position, and index of a texture coordinate or kNone.
  using Corner = std::pair<std::int32_t, std::int32_t>;
  struct Face {
    std::int32_t first_corner = 0;
    std::int32_t num_corners = 0;
    std::int32_t line = 0;  // from 1; 0 in binary files
    std::int32_t part = 0;
  };
  // Names of the object and of the groups that a face belongs to.
  struct Part {
    std::string object;
    std::vector<std::string> groups;
  };

  std::string format;                        // for people, such as "PLY, ascii"
  std::string kind;                          // "OBJ" or "PLY", the beginning of reasons
  int first_number = 0;                      // the number that the format gives the first vertex and face: 0 or 1
  std::vector<Eigen::Vector3d> positions;    // not finite where the file says so
  std::vector<std::int32_t> position_lines;  // from 1; empty in binary files
  std::vector<Eigen::Vector2d> textures;     // see `positions`
  std::vector<Corner> corners;
  std::vector<Face> faces;
  std::vector<Part> parts{1};
  NumberPrecision position_precision;
  NumberPrecision texture_precision;
  bool is_kerf_export = false;     // the file has a comment that begins with kKerfComment
  std::vector<std::string> notes;  // what the reader passed over, for people

  [[nodiscard]] std::span<const Corner> corners_of(const Face& face) const {
    return {corners.data() + face.first_corner, static_cast<std::size_t>(face.num_corners)};
  }
  // Return "face 5 (line 20)" and "vertex 7 (line 9)", with the numbers of the format.
  [[nodiscard]] std::string face_name(std::size_t face) const;
  [[nodiscard]] std::string vertex_name(std::size_t position) const;
  // Returns "face 5 (line 20)", or "faces 5 (line 20), 6 (line 21), 7 (line 22) and 9 more".
  [[nodiscard]] std::string face_names(std::span<const std::int32_t> some) const;
  // Returns the names of objects and groups with faces, in the order of the file, with their numbers of faces.
  [[nodiscard]] std::vector<std::pair<std::string, std::int32_t>> object_sizes() const;
  // Returns an error whose reason begins with the format's name. Its field names the line, if that is not 0.
  [[nodiscard]] Error refuse(const std::string& reason, const std::string& message, std::int64_t line = 0) const;
  // The same for a position, whose line or number the field names ("obj:3", "ply:vertex[2]").
  [[nodiscard]] Error refuse_vertex(const std::string& reason, const std::string& message, std::size_t position) const;
};

// Faults of a file, in the order of their discovery.
class FaultList {
 public:
  void add(Error fault);
  [[nodiscard]] bool empty() const { return num_ == 0; }
  [[nodiscard]] std::size_t size() const { return num_; }
  [[nodiscard]] const std::vector<Error>& shown() const { return shown_; }
  // Returns the first fault, with the messages of the next ones after its own. Copies the list to `all_faults` if
  // that is given.
  [[nodiscard]] Error as_error(FaultList* all_faults = nullptr) const;
  // Returns the messages, and a last line that counts those left out.
  [[nodiscard]] std::vector<std::string> lines() const;

 private:
  std::vector<Error> shown_;  // the first kMaxShownFaults
  std::size_t num_ = 0;
};

// Returns a length with three digits in a unit that suits it, such as "3.2 mm".
std::string length_text(double metres);

// Returns "1 face", or "12 faces".
std::string counted(std::size_t count, const std::string& noun);

}  // namespace kerf::mesh
