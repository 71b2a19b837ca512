#include "server/core/mesh/build/ply_header.h"

#include <algorithm>
#include <array>
#include <utility>

#include "server/core/mesh/build/mesh_file.h"
#include "server/core/mesh/build/ply_import.h"
#include "server/core/mesh/build/tokenizer.h"

namespace kerf::mesh {
namespace {

struct TypeName {
  std::string_view name;
  PlyType type;
};
constexpr std::array<TypeName, 19> kTypeNames{{{"char", PlyType::kInt8},
                                               {"int8", PlyType::kInt8},
                                               {"uchar", PlyType::kUint8},
                                               {"uint8", PlyType::kUint8},
                                               {"short", PlyType::kInt16},
                                               {"int16", PlyType::kInt16},
                                               {"ushort", PlyType::kUint16},
                                               {"uint16", PlyType::kUint16},
                                               {"int", PlyType::kInt32},
                                               {"int32", PlyType::kInt32},
                                               {"uint", PlyType::kUint32},
                                               {"uint32", PlyType::kUint32},
                                               {"float", PlyType::kFloat32},
                                               {"float32", PlyType::kFloat32},
                                               {"double", PlyType::kFloat64},
                                               {"float64", PlyType::kFloat64},
                                               {"int64", PlyType::kInt64},
                                               {"uint64", PlyType::kUint64},
                                               {"float16", PlyType::kFloat16}}};

std::optional<PlyType> type_named(std::string_view name) {
  const auto* const found = std::find_if(kTypeNames.begin(), kTypeNames.end(),
                                         [&](const TypeName& candidate) { return candidate.name == name; });
  return found == kTypeNames.end() ? std::nullopt : std::optional(found->type);
}

template <typename Named>
Named* find_named(std::vector<Named>& all, std::string_view name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Named& each) { return each.name == name; });
  return found == all.end() ? nullptr : &*found;
}

class HeaderReader {
 public:
  explicit HeaderReader(std::string_view& file) : file_(file) {}

  Result<PlyHeader> run() {
    const std::size_t end = file_.find_first_of("\r\n");
    std::string_view magic = file_.substr(0, end);
    if (end == std::string_view::npos || next_token(magic) != "ply" || !next_token(magic).empty()) {
      return refuse("HEADER", "this is not a PLY file: it does not begin with a line \"ply\"");
    }
    const std::size_t after = file_.find_first_not_of('\r', end);
    const bool has_line_feed = after != std::string_view::npos && file_[after] == '\n';
    header_.line_end = file_[end] == '\r' && !has_line_feed ? '\r' : '\n';
    next_line(file_, header_.line_end);
    line_ = 1;
    for (bool at_end = false; !at_end;) {
      ++line_;
      if (file_.empty()) return refuse("HEADER", "the file ends before end_header");
      const std::string_view line = next_line(file_, header_.line_end);
      if (is_comment(line)) continue;
      if (++num_statements_ > kMaxPlyHeaderLines || line.size() > kMaxPlyHeaderLineBytes) {
        return refuse("HEADER", "the header's limits are " + std::to_string(kMaxPlyHeaderLines) + " lines of " +
                                    std::to_string(kMaxPlyHeaderLineBytes) + " bytes");
      }
      KERF_TRY_ASSIGN(at_end, read_line(line));
    }
    header_.num_lines = line_;
    KERF_TRY(assign_roles());
    return std::move(header_);
  }

 private:
  [[nodiscard]] Error refuse(const std::string& reason, const std::string& what) const {
    const std::string line = std::to_string(std::max<std::int64_t>(line_, 1));
    return invalid_argument("PLY_" + reason, "line " + line + ": " + what, "ply:" + line);
  }
  // Returns true if the line is a comment or blank, however long.
  bool is_comment(std::string_view line) {
    const std::string_view keyword = next_token(line);
    if (keyword != "comment" && keyword != "obj_info") return keyword.empty();
    while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
    if (line.starts_with(kKerfComment)) header_.is_kerf_export = true;
    return true;
  }

  // Returns true if this line was the last of the header.
  Result<bool> read_line(std::string_view line) {
    const std::string_view keyword = next_token(line);
    Status read = Nothing{};
    if (keyword == "format") {
      read = read_format(line);
    } else if (keyword == "element") {
      read = read_element(line);
    } else if (keyword == "property") {
      read = read_property(line);
    } else if (keyword != "end_header") {
      return refuse("HEADER", quoted(keyword) + " is not one of format, element, property, comment, end_header");
    }
    KERF_TRY(read);
    if (const std::string_view extra = next_token(line); !extra.empty()) {
      return refuse("HEADER", quoted(extra) + " is unexpected at the end of this line");
    }
    if (keyword == "end_header" && !has_format_) return refuse("HEADER", "a line with the format is missing");
    return keyword == "end_header";
  }

  Status read_format(std::string_view& line) {
    const std::string_view name = next_token(line);
    if (has_format_) return refuse("HEADER", "the format is given twice");
    if (name == "ascii") {
      header_.format = PlyFormat::kAscii;
    } else if (name == "binary_little_endian") {
      header_.format = PlyFormat::kLittleEndian;
    } else if (name == "binary_big_endian") {
      header_.format = PlyFormat::kBigEndian;
    } else {
      return refuse("HEADER",
                    "format " + quoted(name) + " is not one of ascii, binary_little_endian, binary_big_endian");
    }
    if (next_token(line) != "1.0") return refuse("HEADER", "the format's version must be 1.0");
    has_format_ = true;
    return Nothing{};
  }

  Status read_element(std::string_view& line) {
    PlyElement element;
    element.name = next_token(line);
    if (!parse_number(next_token(line), element.count) || element.count < 0) {
      return refuse("HEADER", "an element needs a name and a count, 0 or more");
    }
    if (find_named(header_.elements, element.name) != nullptr) {
      return refuse("HEADER", "element " + quoted(element.name) + " is given twice");
    }
    if (element.name == "vertex") {
      if (element.count > kMaxVertices) {
        return refuse("TOO_LARGE",
                      std::to_string(element.count) + " vertices; the limit is " + std::to_string(kMaxVertices));
      }
      header_.num_vertices = element.count;
    }
    header_.elements.push_back(std::move(element));
    return Nothing{};
  }

  [[nodiscard]] Error unknown_type(std::string_view word) const {
    return refuse(
        "HEADER",
        quoted(word) + " is not a type: char, uchar, short, ushort, int, uint, float, double or int8..float64");
  }

  // Reads a type. In text files an unknown one can be passed over; in binary files its size must be known.
  Status read_type(std::string_view word, PlyType& type) {
    const std::optional<PlyType> found = type_named(word);
    if (!found && (word.empty() || header_.format != PlyFormat::kAscii)) return unknown_type(word);
    type = found.value_or(PlyType::kOther);
    return Nothing{};
  }

  Status read_property(std::string_view& line) {
    if (header_.elements.empty()) return refuse("HEADER", "a property must come after the element it belongs to");
    PlyProperty property;
    std::string_view word = next_token(line);
    if (word == "list") {
      KERF_TRY(read_type(next_token(line), property.count_type.emplace()));
      if (property.count_type == PlyType::kOther) return refuse("HEADER", "the length of a list must be an integer");
      word = next_token(line);
    }
    KERF_TRY(read_type(word, property.type));
    property.name = next_token(line);
    if (property.name.empty()) return refuse("HEADER", "a property needs a name");
    if (property.type == PlyType::kOther && is_read(property.name)) return unknown_type(word);
    std::vector<PlyProperty>& properties = header_.elements.back().properties;
    if (find_named(properties, property.name) != nullptr && is_read(property.name)) {
      return refuse("HEADER", "property " + quoted(property.name) + " is given twice");
    }
    properties.push_back(std::move(property));
    return Nothing{};
  }

  static bool is_read(std::string_view name) {
    constexpr std::array<std::string_view, 11> kRead{
        "x", "y", "z", "s", "t", "u", "v", "texture_u", "texture_v", "vertex_indices", "vertex_index"};
    return std::find(kRead.begin(), kRead.end(), name) != kRead.end();
  }

  // Decides which property of the file is which coordinate. Errors name the last line of the header.
  Status assign_roles() {
    PlyElement* const vertex = find_named(header_.elements, "vertex");
    PlyElement* const face = find_named(header_.elements, "face");
    PlyElement* const strips = find_named(header_.elements, "tristrips");
    if (vertex == nullptr) return refuse("HEADER", "the file has no element vertex");
    if (face == nullptr && strips == nullptr) {
      return refuse("HEADER", "the file has no element face, so it is a cloud of points; a sheet needs faces");
    }
    using Axis = std::pair<std::string_view, PlyRole>;
    for (const auto& [name, role] : {Axis{"x", PlyRole::kX}, Axis{"y", PlyRole::kY}, Axis{"z", PlyRole::kZ}}) {
      PlyProperty* const property = find_named(vertex->properties, name);
      if (property == nullptr && role == PlyRole::kZ) {
        header_.is_plane = true;
        break;
      }
      if (property == nullptr || property->count_type || property->type == PlyType::kOther) {
        return refuse("HEADER", "element vertex must have x, y and, unless it is a plane, z: a number each");
      }
      property->role = role;
    }
    using Pair = std::pair<std::string_view, std::string_view>;
    for (const auto& [x, y] : {Pair{"s", "t"}, Pair{"u", "v"}, Pair{"texture_u", "texture_v"}}) {
      PlyProperty* const first = find_named(vertex->properties, x);
      PlyProperty* const second = find_named(vertex->properties, y);
      if (first == nullptr || second == nullptr || first->count_type || second->count_type) continue;
      if (header_.has_texture) {
        return refuse("HEADER",
                      "element vertex has texture coordinates twice; keep one pair of s t, u v, texture_u texture_v");
      }
      header_.has_texture = true;
      first->role = PlyRole::kTextureX;
      second->role = PlyRole::kTextureY;
    }
    if (strips != nullptr) KERF_TRY(assign_corners(*strips, "tristrips"));
    return face == nullptr ? Status(Nothing{}) : assign_corners(*face, "face");
  }

  Status assign_corners(PlyElement& face, const std::string& name) {
    PlyProperty* const plural = find_named(face.properties, "vertex_indices");
    PlyProperty* const singular = find_named(face.properties, "vertex_index");
    PlyProperty* const corners = plural != nullptr ? plural : singular;
    if (corners == nullptr || (plural != nullptr && singular != nullptr) || !corners->count_type ||
        corners->type == PlyType::kOther) {
      return refuse("HEADER", "element " + name + " must have one list of numbers vertex_indices or vertex_index");
    }
    corners->role = PlyRole::kCorners;
    return Nothing{};
  }

  std::string_view& file_;  // the part that is not read yet
  std::int64_t line_ = 0;
  std::size_t num_statements_ = 1;
  bool has_format_ = false;
  PlyHeader header_;
};

}  // namespace

std::size_t size_of(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUint16:
    case PlyType::kFloat16:
      return 2;
    case PlyType::kInt32:
    case PlyType::kUint32:
    case PlyType::kFloat32:
      return 4;
    case PlyType::kFloat64:
    case PlyType::kInt64:
    case PlyType::kUint64:
      return 8;
    case PlyType::kOther:
      break;
  }
  return 0;
}

Result<PlyHeader> read_ply_header(std::string_view& file) {
  return HeaderReader(file).run();
}

}  // namespace kerf::mesh
