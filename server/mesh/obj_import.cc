#include "server/mesh/obj_import.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <utility>

#include <Eigen/Geometry>

namespace kerf::mesh {
namespace {

// A corner of a face: index of its v line, and of its vt line or kNone.
using ObjCorner = std::pair<std::int32_t, std::int32_t>;

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

// Cuts the next word off the front of `line`; empty at its end.
std::string_view next_word(std::string_view& line) {
  while (!line.empty() && is_space(line.front())) line.remove_prefix(1);
  std::size_t length = 0;
  while (length < line.size() && !is_space(line[length])) ++length;
  const std::string_view word = line.substr(0, length);
  line.remove_prefix(length);
  return word;
}

template <typename Number>
bool parse_number(std::string_view word, Number& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  return code == std::errc{} && end == word.data() + word.size() && !word.empty();
}

class ObjReader {
 public:
  explicit ObjReader(std::string_view text) : text_(text) {}

  Result<ObjSheet> run() {
    if (text_.size() > kMaxObjBytes) {
      return invalid_argument("OBJ_TOO_LARGE",
                              std::to_string(text_.size()) + " bytes; the limit is " + std::to_string(kMaxObjBytes),
                              "obj");
    }
    while (!text_.empty()) {
      ++line_number_;
      const std::size_t length = std::min(text_.find('\n'), text_.size());
      const std::string_view line = text_.substr(0, length);
      text_.remove_prefix(std::min(length + 1, text_.size()));
      if (const Status read = read_line(line); !read.ok()) return read.error();
    }
    line_number_ = 0;
    if (triangles_.empty()) return refuse("OBJ_EMPTY", "no face");
    return assemble();
  }

 private:
  [[nodiscard]] Error refuse(std::string reason, const std::string& what) const {
    if (line_number_ == 0) return invalid_argument(std::move(reason), what, "obj");
    const std::string line = std::to_string(line_number_);
    return invalid_argument(std::move(reason), "line " + line + ": " + what, "obj:" + line);
  }

  Status read_line(std::string_view line) {
    if (line.size() > kMaxObjLineBytes) {
      return refuse("OBJ_LINE_TOO_LONG",
                    std::to_string(line.size()) + " bytes; the limit is " + std::to_string(kMaxObjLineBytes));
    }
    line = line.substr(0, line.find('#'));
    const std::string_view keyword = next_word(line);
    if (keyword == "v") return read_position(line);
    if (keyword == "vt") return read_texture(line);
    if (keyword == "f") return read_face(line);
    return Nothing{};
  }

  Status read_position(std::string_view line) {
    Eigen::Vector3d position;
    for (double& coordinate : position) {
      if (!parse_number(next_word(line), coordinate) || !std::isfinite(coordinate)) {
        return refuse("OBJ_NUMBER", "a position is three finite numbers");
      }
    }
    if (position.cwiseAbs().maxCoeff() > kMaxRestCoordinate) {
      return refuse("OBJ_NUMBER", "a position is at most 1e4 m from the origin in each coordinate");
    }
    if (positions_.size() == static_cast<std::size_t>(kMaxVertices)) {
      return refuse("OBJ_TOO_LARGE", "more than " + std::to_string(kMaxVertices) + " positions");
    }
    positions_.push_back(position);
    return Nothing{};
  }

  Status read_texture(std::string_view line) {
    Eigen::Vector2d uv(0.0, 0.0);
    for (int i = 0; i < 2; ++i) {
      const std::string_view word = next_word(line);
      if (i == 1 && word.empty()) break;  // one-dimensional textures leave v out
      if (!parse_number(word, uv[i]) || !std::isfinite(uv[i])) {
        return refuse("OBJ_NUMBER", "a texture coordinate is one or two finite numbers");
      }
    }
    if (textures_.size() == 4 * static_cast<std::size_t>(kMaxVertices)) {
      return refuse("OBJ_TOO_LARGE", "more than " + std::to_string(4 * kMaxVertices) + " texture coordinates");
    }
    textures_.push_back(uv);
    return Nothing{};
  }

  // "3", or "-1" for the latest one so far, to an index from 0.
  static bool resolve(std::string_view word, std::size_t count, std::int32_t& index) {
    if (!parse_number(word, index)) return false;
    const auto size = static_cast<std::int32_t>(count);
    if (index == 0 || index > size || index < -size) return false;
    index = index > 0 ? index - 1 : size + index;
    return true;
  }

  Status read_face(std::string_view line) {
    std::vector<ObjCorner> corners;
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      const std::size_t slash = std::min(word.find('/'), word.size());
      ObjCorner corner{kNone, kNone};
      if (!resolve(word.substr(0, slash), positions_.size(), corner.first)) {
        return refuse("OBJ_INDEX", "\"" + std::string(word) + "\" names none of " + std::to_string(positions_.size()) +
                                       " positions");
      }
      std::string_view rest = word.substr(std::min(slash + 1, word.size()));
      rest = rest.substr(0, rest.find('/'));
      if (!rest.empty() && !resolve(rest, textures_.size(), corner.second)) {
        return refuse("OBJ_INDEX", "\"" + std::string(word) + "\" names none of " + std::to_string(textures_.size()) +
                                       " texture coordinates");
      }
      const bool has_texture = corner.second != kNone;
      if (!triangles_.empty() || !corners.empty()) {
        if (has_texture != has_texture_) {
          return refuse("OBJ_MIXED_TEXTURE", "some face corners have a texture coordinate and some have not");
        }
      }
      has_texture_ = has_texture;
      corners.push_back(corner);
      if (corners.size() > static_cast<std::size_t>(kMaxObjFaceCorners)) {
        return refuse("OBJ_FACE", "more than " + std::to_string(kMaxObjFaceCorners) + " corners");
      }
    }
    if (corners.size() < 3) return refuse("OBJ_FACE", "a face has at least 3 corners");
    for (std::size_t i = 2; i < corners.size(); ++i) triangles_.push_back({corners[0], corners[i - 1], corners[i]});
    if (triangles_.size() > 2 * static_cast<std::size_t>(kMaxVertices)) {
      return refuse("OBJ_TOO_LARGE", "more than " + std::to_string(2 * kMaxVertices) + " triangles");
    }
    return Nothing{};
  }

  // Vertices are the different corners, by position and then by texture coordinate.
  Result<ObjSheet> assemble() const {
    std::vector<ObjCorner> vertices;
    for (const std::array<ObjCorner, 3>& triangle : triangles_)
      vertices.insert(vertices.end(), triangle.begin(), triangle.end());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    const auto num_vertices = static_cast<Eigen::Index>(vertices.size());
    ObjSheet obj;
    obj.world.resize(3, num_vertices);
    for (Eigen::Index v = 0; v < num_vertices; ++v) {
      obj.obj_positions.push_back(vertices[v].first);
      obj.world.col(v) = positions_[vertices[v].first];
    }
    obj.sheet.triangles.resize(3, static_cast<Eigen::Index>(triangles_.size()));
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const auto at = std::lower_bound(vertices.begin(), vertices.end(), triangles_[t][k]);
        obj.sheet.triangles(k, static_cast<Eigen::Index>(t)) = static_cast<std::int32_t>(at - vertices.begin());
      }
    }
    if (has_texture_) {
      obj.sheet.rest.resize(2, num_vertices);
      for (Eigen::Index v = 0; v < num_vertices; ++v) {
        obj.sheet.rest.col(v) = textures_[vertices[v].second];
      }
      return obj;
    }
    if (const Status flat = flatten(obj); !flat.ok()) return flat.error();
    return obj;
  }

  // Rest shape of a planar sheet. Its normal is the direction of the sum of the triangles' area vectors.
  Status flatten(ObjSheet& obj) const {
    const Eigen::Vector3d origin = obj.world.col(0);
    Eigen::Vector3d area = Eigen::Vector3d::Zero();
    for (Eigen::Index t = 0; t < obj.sheet.triangles.cols(); ++t) {
      const Eigen::Vector3d a = obj.world.col(obj.sheet.triangles(0, t));
      const Eigen::Vector3d b = obj.world.col(obj.sheet.triangles(1, t));
      const Eigen::Vector3d c = obj.world.col(obj.sheet.triangles(2, t));
      area += (b - a).cross(c - a);
    }
    const Eigen::Vector3d extent = obj.world.rowwise().maxCoeff() - obj.world.rowwise().minCoeff();
    const double size = extent.maxCoeff();
    constexpr double kFlatness = 1e-6;  // -, of the size of the sheet; single-precision files round by about 1e-7
    if (!(area.norm() > kFlatness * size * size)) {
      return refuse("OBJ_NOT_PLANAR", "the faces have no common plane; give them texture coordinates as rest shape");
    }
    const Eigen::Vector3d normal = area.normalized();
    for (Eigen::Index v = 0; v < obj.world.cols(); ++v) {
      const Eigen::Vector3d position = obj.world.col(v);
      const double height = std::abs(normal.dot(position - origin));
      if (height > kFlatness * size) {
        return refuse("OBJ_NOT_PLANAR",
                      "position " + std::to_string(obj.obj_positions[v] + 1) + " is " + std::to_string(height) +
                          " m out of the plane of the first one, the limit is " + std::to_string(kFlatness * size) +
                          " m; give the faces texture coordinates as rest shape");
      }
    }
    obj.sheet.rest.resize(2, obj.world.cols());
    if (std::abs(normal.z()) > 1.0 - kFlatness) {
      obj.sheet.rest = obj.world.topRows<2>();
      return Nothing{};
    }
    // The axis that is least along the normal, projected into the plane, is the rest x axis.
    Eigen::Index axis = 0;
    normal.cwiseAbs().minCoeff(&axis);
    const Eigen::Vector3d u = (Eigen::Vector3d::Unit(axis) - normal[axis] * normal).normalized();
    const Eigen::Vector3d v = normal.cross(u);
    for (Eigen::Index i = 0; i < obj.world.cols(); ++i) {
      const Eigen::Vector3d offset = obj.world.col(i) - origin;
      obj.sheet.rest.col(i) = Eigen::Vector2d(u.dot(offset), v.dot(offset));
    }
    return Nothing{};
  }

  std::string_view text_;         // what is left of it
  std::int64_t line_number_ = 0;  // 0: about the file as a whole
  std::vector<Eigen::Vector3d> positions_;
  std::vector<Eigen::Vector2d> textures_;
  std::vector<std::array<ObjCorner, 3>> triangles_;
  bool has_texture_ = false;
};

}  // namespace

Result<ObjSheet> parse_obj(std::string_view text) {
  return ObjReader(text).run();
}

}  // namespace kerf::mesh
