#include "server/core/mesh/build/obj_import.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "server/base/interruption.h"
#include "server/base/text_encoding.h"
#include "server/core/mesh/build/tokenizer.h"

namespace kerf::mesh {
namespace {

class ObjReader {
 public:
  ObjReader(std::string_view text, std::int32_t version)
      : text_(without_byte_order_mark(text)), start_(text_.substr(0, 512)), is_first_reader_(version == kFirstReader) {
    file_.kind = "OBJ";
    file_.format = "OBJ";
    file_.first_number = 1;
  }

  Result<MeshFile> run(FaultList* all_faults) {
    if (text_.size() > kMaxMeshFileBytes) {
      return file_.refuse("TOO_LARGE",
                          std::to_string(text_.size()) + " bytes; the limit is " + std::to_string(kMaxMeshFileBytes));
    }
    while (!text_.empty()) {
      const std::string_view line = next_statement();
      interruption_point();
      read_statement(line);
      if (is_too_large_) break;
    }
    if (!is_too_large_) check_indices();
    if (!faults_.empty()) return faults_.as_error(all_faults);
    if (file_.faces.empty()) return file_.refuse("EMPTY", no_face());
    return std::move(file_);
  }

 private:
  void refuse(const std::string& reason, const std::string& what) {
    faults_.add(file_.refuse(reason, what, statement_line_));
  }

  // Removes the next line from the front of the text. Any of LF, CR LF and CR ends it, for the first reader only LF.
  std::string_view next_physical_line() {
    ++line_;
    if (is_first_reader_) return next_line(text_, '\n');
    const std::size_t length = std::min(text_.find_first_of("\r\n"), text_.size());
    const std::string_view line = text_.substr(0, length);
    const bool is_pair = text_.substr(length).starts_with("\r\n");
    text_.remove_prefix(std::min(length + (is_pair ? 2 : 1), text_.size()));
    return line;
  }

  // Returns the next line without its comment. A backslash at its end, unless in a comment, appends the next line.
  std::string_view next_statement() {
    std::string_view line = without_comment(next_physical_line());
    statement_line_ = line_;
    if (is_first_reader_ || !ends_with_backslash(line)) return line;
    joined_.clear();
    while (ends_with_backslash(line)) {
      joined_ += line.substr(0, line.find_last_of('\\'));
      joined_ += ' ';
      line = text_.empty() ? std::string_view() : without_comment(next_physical_line());
    }
    joined_ += line;
    return joined_;
  }

  static bool ends_with_backslash(std::string_view line) {
    const std::size_t last = line.find_last_not_of(" \t");
    return last != std::string_view::npos && line[last] == '\\';
  }

  // Removes a comment, which begins a line or follows a blank. The first reader ends lines at any #.
  std::string_view without_comment(std::string_view line) {
    for (std::size_t at = line.find('#'); at != std::string_view::npos; at = line.find('#', at + 1)) {
      if (at > 0 && !is_blank(line[at - 1]) && !is_first_reader_) continue;
      std::string_view comment = line.substr(at + 1);
      while (!comment.empty() && is_blank(comment.front())) comment.remove_prefix(1);
      if (comment.starts_with(kKerfComment)) file_.is_kerf_export = true;
      return line.substr(0, at);
    }
    return line;
  }

  void read_statement(std::string_view line) {
    std::string_view keyword = next_token(line);
    if (!is_first_reader_) {
      keyword = without_byte_order_mark(keyword);  // of a file that was appended to another
      if (is_glued(keyword))
        return refuse("NUMBER", quoted(keyword) + " must have plain blanks after its first letter");
    }
    if (keyword == "v") return read_position(line);
    if (keyword == "vt") return read_texture(line);
    if (keyword == "f" || (keyword == "fo" && !is_first_reader_)) return read_face(line);
    if (keyword == "o") return begin_part({trimmed(line), {}});
    if (keyword == "g") return begin_part({file_.parts.back().object, words_of(line)});
    if (keyword == "l" || keyword == "p") ++num_lines_and_points_;
    if (keyword == "surf") ++num_surfaces_;
  }

  // Returns true for a vertex or face whose letter is followed by a character beyond ASCII, such as a no-break space.
  static bool is_glued(std::string_view keyword) {
    const std::size_t letters = keyword.starts_with("vt") ? 2 : 1;
    return keyword.size() > letters && (keyword[0] == 'v' || keyword[0] == 'f') &&
           static_cast<unsigned char>(keyword[letters]) >= 0x80;
  }

  static std::string trimmed(std::string_view line) {
    while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
    while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
    return std::string(line);
  }

  static std::vector<std::string> words_of(std::string_view line) {
    std::vector<std::string> words;
    for (std::string_view word = next_token(line); !word.empty(); word = next_token(line)) words.emplace_back(word);
    return words;
  }

  // Begins the faces of another object or group. A part without faces is replaced.
  void begin_part(MeshFile::Part part) {
    const auto current = static_cast<std::int32_t>(file_.parts.size()) - 1;
    if (file_.faces.empty() || file_.faces.back().part != current) {
      file_.parts.back() = std::move(part);
    } else {
      file_.parts.push_back(std::move(part));
    }
  }

  [[nodiscard]] static std::string not_a_number(std::string_view word, const std::string& what) {
    if (word.empty()) return what;
    return what + "; " + quoted(word) + " is no number" +
           (word.find(',') != std::string_view::npos ? ": decimals follow a point, not a comma" : "");
  }

  void read_position(std::string_view line) {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    for (double& coordinate : position) {
      const std::string_view word = next_token(line);
      if (!parse_coordinate(word, coordinate)) {
        refuse("NUMBER", not_a_number(word, "a position is three numbers"));
        break;
      }
      file_.position_precision.add(word, coordinate);
    }
    constexpr auto kMost = static_cast<std::size_t>(kMaxVertices);
    if (file_.positions.size() == kMost) return too_many(kMost, "positions");
    file_.positions.push_back(position);
    file_.position_lines.push_back(static_cast<std::int32_t>(statement_line_));
  }

  void read_texture(std::string_view line) {
    Eigen::Vector2d uv(0.0, 0.0);
    for (int i = 0; i < 2; ++i) {
      const std::string_view word = next_token(line);
      if (i == 1 && word.empty()) break;  // one-dimensional textures leave v out
      if (!parse_coordinate(word, uv[i])) {
        refuse("NUMBER", not_a_number(word, "a texture coordinate is one or two numbers"));
        break;
      }
      file_.texture_precision.add(word, uv[i]);
    }
    constexpr std::size_t kMost = 4 * static_cast<std::size_t>(kMaxVertices);
    if (file_.textures.size() == kMost) return too_many(kMost, "texture coordinates");
    file_.textures.push_back(uv);
  }

  // Reads an index. "1" is the first entry of the file, which may come later; "-1" is the latest one so far. Returns
  // false if it cannot name any.
  static bool resolve(std::string_view word, std::size_t count, std::int32_t& index) {
    if (!parse_number(word, index)) return false;
    const auto size = static_cast<std::int32_t>(count);
    if (index == 0 || index < -size) return false;
    index = index > 0 ? index - 1 : size + index;
    return true;
  }

  void read_face(std::string_view line) {
    MeshFile::Face face;
    face.first_corner = static_cast<std::int32_t>(file_.corners.size());
    face.line = static_cast<std::int32_t>(statement_line_);
    face.part = static_cast<std::int32_t>(file_.parts.size()) - 1;
    bool is_sound = true;
    for (std::string_view word = next_token(line); !word.empty() && is_sound; word = next_token(line)) {
      const std::size_t slash = std::min(word.find('/'), word.size());
      MeshFile::Corner corner{kNone, kNone};
      std::string_view rest = word.substr(std::min(slash + 1, word.size()));
      rest = rest.substr(0, rest.find('/'));
      is_sound = resolve(word.substr(0, slash), file_.positions.size(), corner.first) &&
                 (rest.empty() || resolve(rest, file_.textures.size(), corner.second));
      if (!is_sound) refuse("INDEX", quoted(word) + " names no vertex: numbers begin at 1, or count back from -1");
      file_.corners.push_back(corner);
      ++face.num_corners;
    }
    if (is_sound && face.num_corners < 3) {
      is_sound = false;
      refuse("FACE", "a face has at least 3 corners; this one has " + std::to_string(face.num_corners));
    }
    if (face.num_corners > static_cast<std::int32_t>(kMaxFaceCorners)) {
      is_sound = false;
      refuse("FACE", "more than " + std::to_string(kMaxFaceCorners) + " corners");
    }
    if (!is_sound) return file_.corners.resize(static_cast<std::size_t>(face.first_corner));
    constexpr std::size_t kMost = 2 * static_cast<std::size_t>(kMaxVertices);
    num_triangles_ += static_cast<std::size_t>(face.num_corners) - 2;
    if (num_triangles_ > kMost) return too_many(kMost, "triangles");
    file_.faces.push_back(face);
  }

  void too_many(std::size_t limit, const std::string& what) {
    is_too_large_ = true;
    refuse("TOO_LARGE", "more than " + std::to_string(limit) + " " + what);
  }

  // Checks that the corners name entries of the file.
  void check_indices() {
    const auto num_positions = static_cast<std::int32_t>(file_.positions.size());
    const auto num_textures = static_cast<std::int32_t>(file_.textures.size());
    for (const MeshFile::Face& face : file_.faces) {
      interruption_point();
      for (const MeshFile::Corner& corner : file_.corners_of(face)) {
        const bool is_position = corner.first < num_positions;
        if (is_position && corner.second < num_textures) continue;
        statement_line_ = face.line;
        refuse("INDEX", is_position ? "\"" + std::to_string(corner.second + 1) + "\" must name one of the " +
                                          std::to_string(num_textures) + " texture coordinates"
                                    : "\"" + std::to_string(corner.first + 1) + "\" must name one of the " +
                                          std::to_string(num_positions) + " positions");
        break;
      }
    }
  }

  // Returns the format of a file that is none of OBJ; empty if it is not known.
  [[nodiscard]] std::string other_format() const {
    std::string_view rest = start_;
    while (!rest.empty() && (is_blank(rest.front()) || rest.front() == '\n')) rest.remove_prefix(1);
    const auto begins = [rest](std::string_view with) { return rest.starts_with(with); };
    if (begins("solid") && rest.find("facet") != std::string_view::npos) return "an STL file";
    if (begins("OFF") || begins("COFF")) return "an OFF file";
    if (begins("glTF")) return "a binary glTF file";
    if (begins("ply")) return "a PLY file";
    if (begins("{")) return rest.find("asset") != std::string_view::npos ? "a glTF file" : "a JSON file";
    if (begins("<")) return "an XML file";
    // Bytes beyond ASCII have become UTF-8, as those of ISO-8859-1 do.
    if (begins("\x1f\x8b") || begins("\x1f\xc2\x8b") || begins("BZh") ||
        begins("\xc3\xbd"
               "7zXZ") ||
        begins("(\xc2\xb5/\xc3\xbd")) {
      return "a compressed file";
    }
    if (begins("PK\x03\x04")) return "a ZIP archive";
    return rest.find('\0') != std::string_view::npos ? "not text" : "";
  }

  [[nodiscard]] std::string no_face() const {
    if (const std::string other = file_.positions.empty() ? other_format() : ""; !other.empty()) {
      return "no face: the file is " + other + ", and this reads OBJ; save it as OBJ or PLY, unpacked, in UTF-8";
    }
    const std::string what = "no face: the file has " + counted(file_.positions.size(), "position");
    if (num_surfaces_ > 0) return what + " and free-form surfaces, which are not read; export it as polygons";
    if (num_lines_and_points_ > 0) return what + ", lines or points, and a sheet needs faces (lines that begin with f)";
    return what + ", and a sheet needs faces (lines that begin with f)";
  }

  std::string_view text_;   // the part that is not read yet
  std::string_view start_;  // of the file
  bool is_first_reader_ = false;
  std::int64_t line_ = 0;            // of the file, from 1
  std::int64_t statement_line_ = 0;  // the first line of the statement
  std::string joined_;               // a statement of several lines
  std::size_t num_triangles_ = 0;
  std::size_t num_lines_and_points_ = 0;
  std::size_t num_surfaces_ = 0;
  bool is_too_large_ = false;
  MeshFile file_;
  FaultList faults_;
};

}  // namespace

Result<MeshFile> read_obj(std::string_view text, std::int32_t version, FaultList* faults) {
  return ObjReader(text, version).run(faults);
}

Result<ImportedSheet> parse_obj(std::string_view text, const MeshReading& reading) {
  KERF_TRY_ASSIGN(const MeshFile file, read_obj(text, reading.version));
  return assemble(file, reading);
}

}  // namespace kerf::mesh
