#include "server/core/mesh/build/obj_import.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "server/base/interruption.h"
#include "server/core/mesh/build/tokenizer.h"

namespace kerf::mesh {
namespace {

class ObjReader {
 public:
  explicit ObjReader(std::string_view text) : text_(text) {}

  Result<ImportedSheet> run(RestShape rest_shape) {
    if (text_.size() > kMaxMeshFileBytes) {
      return refuse("TOO_LARGE",
                    std::to_string(text_.size()) + " bytes; the limit is " + std::to_string(kMaxMeshFileBytes));
    }
    while (!text_.empty()) {
      ++line_number_;
      KERF_TRY(read_line(next_line(text_, '\n')));
    }
    line_number_ = 0;
    Result<ImportedSheet> assembled = faces_.assemble(rest_shape);
    if (!assembled.ok()) return here(assembled.error());
    return assembled;
  }

 private:
  // Adds the place in the file to an error of FaceList or of this reader.
  [[nodiscard]] Error here(Error error) const {
    error.reason = "OBJ_" + error.reason;
    error.field = "obj";
    if (line_number_ == 0) return error;  // the error concerns the file as a whole
    const std::string line = std::to_string(line_number_);
    error.message = "line " + line + ": " + error.message;
    error.field += ":" + line;
    return error;
  }
  [[nodiscard]] Error refuse(std::string reason, std::string what) const {
    return here(invalid_argument(std::move(reason), std::move(what)));
  }
  [[nodiscard]] Status added(const Status& status) const { return status.ok() ? status : Status(here(status.error())); }

  Status read_line(std::string_view line) {
    interruption_point();
    if (line.size() > kMaxObjLineBytes) {
      return refuse("LINE_TOO_LONG",
                    std::to_string(line.size()) + " bytes; the limit is " + std::to_string(kMaxObjLineBytes));
    }
    line = line.substr(0, line.find('#'));
    const std::string_view keyword = next_token(line);
    if (keyword == "v") return read_position(line);
    if (keyword == "vt") return read_texture(line);
    if (keyword == "f") return read_face(line);
    return Nothing{};
  }

  Status read_position(std::string_view line) {
    Eigen::Vector3d position;
    for (double& coordinate : position) {
      if (!parse_number(next_token(line), coordinate)) return refuse("NUMBER", "a position is three finite numbers");
    }
    return added(faces_.add_position(position));
  }

  Status read_texture(std::string_view line) {
    Eigen::Vector2d uv(0.0, 0.0);
    for (int i = 0; i < 2; ++i) {
      const std::string_view word = next_token(line);
      if (i == 1 && word.empty()) break;  // one-dimensional textures leave v out
      if (!parse_number(word, uv[i])) return refuse("NUMBER", "a texture coordinate is one or two finite numbers");
    }
    return added(faces_.add_texture(uv));
  }

  // Converts an index of the file to one from 0. "1" is the first of `count` entries, "-1" the latest one so far.
  static bool resolve(std::string_view word, std::size_t count, std::int32_t& index) {
    if (!parse_number(word, index)) return false;
    const auto size = static_cast<std::int32_t>(count);
    if (index == 0 || index > size || index < -size) return false;
    index = index > 0 ? index - 1 : size + index;
    return true;
  }

  Status read_face(std::string_view line) {
    std::vector<FaceList::Corner> corners;
    for (std::string_view word = next_token(line); !word.empty(); word = next_token(line)) {
      const std::size_t slash = std::min(word.find('/'), word.size());
      FaceList::Corner corner{kNone, kNone};
      if (!resolve(word.substr(0, slash), faces_.num_positions(), corner.first)) {
        return refuse("INDEX",
                      quoted(word) + " must name one of the " + std::to_string(faces_.num_positions()) + " positions");
      }
      std::string_view rest = word.substr(std::min(slash + 1, word.size()));
      rest = rest.substr(0, rest.find('/'));
      if (!rest.empty() && !resolve(rest, faces_.num_textures(), corner.second)) {
        return refuse("INDEX", quoted(word) + " must name one of the " + std::to_string(faces_.num_textures()) +
                                   " texture coordinates");
      }
      corners.push_back(corner);
    }
    return added(faces_.add_face(corners));
  }

  std::string_view text_;         // the part that is not read yet
  std::int64_t line_number_ = 0;  // 0: errors concern the file as a whole
  FaceList faces_{1};
};

}  // namespace

Result<ImportedSheet> parse_obj(std::string_view text, RestShape rest_shape) {
  return ObjReader(text).run(rest_shape);
}

}  // namespace kerf::mesh
