#include "server/core/mesh/build/ply_import.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "server/base/interruption.h"
#include "server/base/text_encoding.h"
#include "server/core/mesh/build/ply_header.h"
#include "server/core/mesh/build/tokenizer.h"

namespace kerf::mesh {
namespace {

// Converts a number of 16 bits, as IEEE 754 defines it.
double decode_half(std::uint32_t bits) {
  const std::uint32_t exponent = bits >> 10 & 0x1f;
  const auto fraction = static_cast<double>(bits & 0x3ff);
  double value = std::numeric_limits<double>::quiet_NaN();
  if (exponent == 0) value = std::ldexp(fraction, -24);
  if (exponent > 0 && exponent < 0x1f) value = std::ldexp(1024.0 + fraction, static_cast<int>(exponent) - 25);
  return (bits & 0x8000) != 0 ? -value : value;
}

// Converts the bytes of a number. The most significant byte comes first if the file is big-endian, else last.
double decode(PlyType type, std::string_view bytes, bool is_big_endian) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bits = bits << 8 | static_cast<unsigned char>(bytes[is_big_endian ? i : bytes.size() - 1 - i]);
  }
  switch (type) {
    case PlyType::kInt8:
      return static_cast<std::int8_t>(bits);
    case PlyType::kUint8:
      return static_cast<std::uint8_t>(bits);
    case PlyType::kInt16:
      return static_cast<std::int16_t>(bits);
    case PlyType::kUint16:
      return static_cast<std::uint16_t>(bits);
    case PlyType::kInt32:
      return static_cast<std::int32_t>(bits);
    case PlyType::kUint32:
      return static_cast<std::uint32_t>(bits);
    case PlyType::kFloat32:
      return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    case PlyType::kFloat64:
      return std::bit_cast<double>(bits);
    case PlyType::kInt64:
      return static_cast<double>(static_cast<std::int64_t>(bits));
    case PlyType::kUint64:
      return static_cast<double>(bits);
    case PlyType::kFloat16:
      return decode_half(static_cast<std::uint32_t>(bits));
    case PlyType::kOther:
      break;
  }
  return 0.0;
}

// Returns the distance from 1 to the next number of a binary type; 0 for integers, which are exact.
double step_of(PlyType type) {
  switch (type) {
    case PlyType::kFloat16:
      return 0x1p-10;
    case PlyType::kFloat32:
      return 0x1p-23;
    case PlyType::kFloat64:
      return 0x1p-52;
    default:
      return 0.0;
  }
}

bool is_end_of_line(char c) {
  return is_blank(c) || c == '\n';
}

// Marks of the end of a text file, which some programs append.
bool is_end_of_text(char c) {
  return is_end_of_line(c) || c == '\0' || c == '\x1a';
}

std::string format_name(PlyFormat format) {
  switch (format) {
    case PlyFormat::kAscii:
      return "PLY, ascii";
    case PlyFormat::kLittleEndian:
      return "PLY, binary_little_endian";
    case PlyFormat::kBigEndian:
      break;
  }
  return "PLY, binary_big_endian";
}

class PlyReader {
 public:
  explicit PlyReader(std::string_view file) : file_(without_byte_order_mark(file)) { mesh_.kind = "PLY"; }

  Result<MeshFile> run(FaultList* all_faults) {
    if (file_.size() > kMaxMeshFileBytes) {
      return mesh_.refuse("TOO_LARGE",
                          std::to_string(file_.size()) + " bytes; the limit is " + std::to_string(kMaxMeshFileBytes));
    }
    KERF_TRY_ASSIGN(header_, read_ply_header(file_));
    line_ = header_.num_lines;
    mesh_.format = format_name(header_.format);
    mesh_.is_kerf_export = header_.is_kerf_export;
    if (header_.is_plane) mesh_.notes.push_back("vertices have no z: it is taken as 0");
    for (const PlyElement& element : header_.elements) {
      if (element.properties.empty()) continue;  // takes no space in the file, whatever its count
      element_ = &element;
      for (row_ = 0; row_ < element.count; ++row_) {
        interruption_point();
        if (const Status read = read_row(); !read.ok()) {
          faults_.add(read.error());
          return faults_.as_error(all_faults);
        }
      }
    }
    element_ = nullptr;
    if (!std::all_of(file_.begin(), file_.end(), is_text() ? is_end_of_text : is_end_of_line)) {
      const std::string bytes = file_.size() == 1 ? "1 byte follows" : std::to_string(file_.size()) + " bytes follow";
      faults_.add(refuse("TRAILING", bytes + " the last element; the header's counts do not match"));
    }
    if (!faults_.empty()) return faults_.as_error(all_faults);
    if (mesh_.faces.empty()) return refuse("EMPTY", "no face: a sheet needs some");
    return std::move(mesh_);
  }

 private:
  [[nodiscard]] bool is_text() const { return header_.format == PlyFormat::kAscii; }

  // Returns an error that names the place in the file.
  [[nodiscard]] Error refuse(const std::string& reason, const std::string& what) const {
    if (element_ == nullptr) return mesh_.refuse(reason, what);  // the error concerns the file as a whole
    const std::string place = shown_name() + " " + std::to_string(row_);
    if (is_text()) {
      Error error = mesh_.refuse(reason, what, line_);
      error.message = "line " + std::to_string(line_) + " (" + place + "): " + what;
      return error;
    }
    Error error = mesh_.refuse(reason, place + ": " + what);
    error.field += ":" + shown_name() + "[" + std::to_string(row_) + "]";
    return error;
  }
  [[nodiscard]] std::string shown_name() const {
    const std::string& name = element_->name;
    return name == "vertex" || name == "face" || name == "tristrips" ? name : quoted(name);
  }

  // Reads one vertex, face or other element.
  Status read_row() {
    if (is_text()) {
      KERF_TRY(find_line());
    }
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Eigen::Vector2d texture = Eigen::Vector2d::Zero();
    for (const PlyProperty& property : element_->properties) {
      KERF_TRY(property.count_type ? read_list(property) : read_scalar(property, position, texture));
    }
    if (is_text() && !next_token(row_text_).empty()) {
      return refuse("VALUES", "the line has more values than the header declares for this element");
    }
    if (element_->name == "face") return add_face(indices_);
    if (element_->name == "tristrips") return add_strips();
    if (element_->name != "vertex") return Nothing{};
    if (header_.has_texture) mesh_.textures.push_back(texture);
    mesh_.positions.push_back(position);
    if (is_text()) mesh_.position_lines.push_back(static_cast<std::int32_t>(line_));
    return Nothing{};
  }

  // Adds a face, or its faults. Error: TOO_LARGE.
  Status add_face(std::span<const std::int64_t> indices) {
    if (indices.size() < 3) {
      faults_.add(refuse("FACE", "a face has at least 3 corners; this one has " + std::to_string(indices.size())));
      return Nothing{};
    }
    constexpr std::size_t kMost = 2 * static_cast<std::size_t>(kMaxVertices);
    num_triangles_ += indices.size() - 2;
    if (num_triangles_ > kMost) return refuse("TOO_LARGE", "more than " + std::to_string(kMost) + " triangles");
    MeshFile::Face face;
    face.first_corner = static_cast<std::int32_t>(mesh_.corners.size());
    face.num_corners = static_cast<std::int32_t>(indices.size());
    face.line = is_text() ? static_cast<std::int32_t>(line_) : 0;
    for (const std::int64_t index : indices) {
      if (index < 0 || index >= header_.num_vertices) {
        faults_.add(refuse("INDEX", std::to_string(index) + " must name one of the " +
                                        std::to_string(header_.num_vertices) + " vertices, which count from 0"));
        mesh_.corners.resize(static_cast<std::size_t>(face.first_corner));
        return Nothing{};
      }
      const auto vertex = static_cast<std::int32_t>(index);
      mesh_.corners.emplace_back(vertex, header_.has_texture ? vertex : kNone);
    }
    mesh_.faces.push_back(face);
    return Nothing{};
  }

  // Adds the triangles of strips, each of which turns like the first of its strip. Triangles with a corner twice only
  // lead a strip elsewhere.
  Status add_strips() {
    std::size_t first = 0;
    for (std::size_t i = 0; i < indices_.size(); ++i) {
      if (indices_[i] < 0) first = i + 1;
      if (i < first + 2 || indices_[i] < 0) continue;
      const std::int64_t a = indices_[i - 2], b = indices_[i - 1], c = indices_[i];
      if (a == b || b == c || c == a) continue;
      const bool is_odd = (i - first) % 2 != 0;
      const std::array<std::int64_t, 3> corners{is_odd ? b : a, is_odd ? a : b, c};
      KERF_TRY(add_face(corners));
    }
    return Nothing{};
  }

  // Sets row_text_ to the next line that is not blank.
  Status find_line() {
    row_text_ = {};
    while (!file_.empty()) {
      ++line_;
      row_text_ = next_line(file_, header_.line_end);
      if (!std::all_of(row_text_.begin(), row_text_.end(), is_end_of_line)) return Nothing{};
    }
    return refuse("TRUNCATED",
                  "the file ends here; the header promises " + std::to_string(element_->count) + " of them");
  }

  Status read_scalar(const PlyProperty& property, Eigen::Vector3d& position, Eigen::Vector2d& texture) {
    switch (property.role) {
      case PlyRole::kX:
        return read_number(property.type, position.x(), &mesh_.position_precision);
      case PlyRole::kY:
        return read_number(property.type, position.y(), &mesh_.position_precision);
      case PlyRole::kZ:
        return read_number(property.type, position.z(), &mesh_.position_precision);
      case PlyRole::kTextureX:
        return read_number(property.type, texture.x(), &mesh_.texture_precision);
      case PlyRole::kTextureY:
        return read_number(property.type, texture.y(), &mesh_.texture_precision);
      case PlyRole::kSkipped:
      case PlyRole::kCorners:
        break;
    }
    return skip(property.type, 1);
  }

  Status read_list(const PlyProperty& property) {
    double count = 0.0;
    KERF_TRY(read_number(*property.count_type, count));
    if (!(count >= 0.0 && count <= 4294967295.0 && count == std::floor(count))) {
      return refuse("VALUES", "the length of a list must be a whole number, 0 or more");
    }
    const auto length = static_cast<std::uint64_t>(count);
    if (property.role != PlyRole::kCorners) return skip(property.type, length);
    indices_.clear();
    const std::size_t most = element_->name == "face" ? kMaxFaceCorners : 4 * static_cast<std::size_t>(kMaxVertices);
    if (length > most) return refuse("FACE", "more than " + std::to_string(most) + " corners");
    for (std::uint64_t i = 0; i < length; ++i) {
      double index = 0.0;
      KERF_TRY(read_number(property.type, index));
      if (!(std::abs(index) <= 4294967295.0 && index == std::floor(index))) {
        return refuse("INDEX", "a corner must name one of the " + std::to_string(header_.num_vertices) + " vertices");
      }
      indices_.push_back(static_cast<std::int64_t>(index));
    }
    return Nothing{};
  }

  Status read_number(PlyType type, double& value, NumberPrecision* precision = nullptr) {
    if (is_text()) {
      const std::string_view word = next_token(row_text_);
      if (word.empty()) return too_few();
      if (!parse_coordinate(word, value)) return refuse("NUMBER", quoted(word) + " is not a number");
      if (precision != nullptr) precision->add(word, value);
      return Nothing{};
    }
    const std::size_t size = size_of(type);
    if (file_.size() < size) return truncated();
    value = decode(type, file_.substr(0, size), header_.format == PlyFormat::kBigEndian);
    if (precision != nullptr) precision->add_binary(value, step_of(type));
    file_.remove_prefix(size);
    return Nothing{};
  }

  Status skip(PlyType type, std::uint64_t count) {
    if (is_text()) {
      for (std::uint64_t i = 0; i < count; ++i) {
        if (next_token(row_text_).empty()) return too_few();
      }
      return Nothing{};
    }
    const std::uint64_t size = count * size_of(type);
    if (file_.size() < size) return truncated();
    file_.remove_prefix(size);
    return Nothing{};
  }

  [[nodiscard]] Error too_few() const {
    return refuse("VALUES", "the line has fewer values than the header declares for this element");
  }
  [[nodiscard]] Error truncated() const {
    return refuse("TRUNCATED",
                  "the file ends within it; the header promises " + std::to_string(element_->count) + " of them");
  }

  std::string_view file_;      // the part that is not read yet
  std::string_view row_text_;  // the part of the line that is not read yet
  PlyHeader header_;
  const PlyElement* element_ = nullptr;  // the element being read
  std::int64_t row_ = 0;
  std::int64_t line_ = 0;
  std::vector<std::int64_t> indices_;  // the list of vertices of the row
  std::size_t num_triangles_ = 0;
  MeshFile mesh_;
  FaultList faults_;
};

}  // namespace

Result<MeshFile> read_ply(std::string_view file, FaultList* faults) {
  return PlyReader(file).run(faults);
}

Result<ImportedSheet> parse_ply(std::string_view file, const MeshReading& reading) {
  KERF_TRY_ASSIGN(const MeshFile read, read_ply(file));
  return assemble(read, reading);
}

}  // namespace kerf::mesh
