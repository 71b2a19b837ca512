#include "server/core/mesh/build/ply_import.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "server/base/interruption.h"
#include "server/core/mesh/build/ply_header.h"
#include "server/core/mesh/build/tokenizer.h"

namespace kerf::mesh {
namespace {

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
  }
  return 0.0;
}

bool is_end_of_line(char c) {
  return is_blank(c) || c == '\n';
}

class PlyReader {
 public:
  explicit PlyReader(std::string_view file) : file_(file) {}

  Result<ImportedSheet> run(RestShape rest_shape) {
    if (file_.size() > kMaxMeshFileBytes) {
      return invalid_argument(
          "PLY_TOO_LARGE", std::to_string(file_.size()) + " bytes; the limit is " + std::to_string(kMaxMeshFileBytes),
          "ply");
    }
    KERF_TRY_ASSIGN(header_, read_ply_header(file_));
    line_ = header_.num_lines;
    for (const PlyElement& element : header_.elements) {
      if (element.properties.empty()) continue;  // takes no space in the file, whatever its count
      element_ = &element;
      for (row_ = 0; row_ < element.count; ++row_) {
        interruption_point();
        KERF_TRY(read_row());
      }
    }
    element_ = nullptr;
    if (!std::all_of(file_.begin(), file_.end(), is_end_of_line)) {
      return here(invalid_argument("TRAILING", std::to_string(file_.size()) +
                                                   " bytes follow the last element; the header's counts do not match"));
    }
    Result<ImportedSheet> assembled = faces_.assemble(rest_shape);
    if (!assembled.ok()) return here(assembled.error());
    return assembled;
  }

 private:
  [[nodiscard]] bool is_text() const { return header_.format == PlyFormat::kAscii; }

  // Adds the place in the file to an error of FaceList or of this reader.
  [[nodiscard]] Error here(Error error) const {
    error.reason = "PLY_" + error.reason;
    error.field = "ply";
    if (element_ == nullptr) return error;  // the error concerns the file as a whole
    const std::string number = std::to_string(row_);
    if (is_text()) {
      error.field += ":" + std::to_string(line_);
      error.message = "line " + std::to_string(line_) + " (" + shown_name() + " " + number + "): " + error.message;
    } else {
      error.field += ":" + shown_name() + "[" + number + "]";
      error.message = shown_name() + " " + number + ": " + error.message;
    }
    return error;
  }
  [[nodiscard]] std::string shown_name() const {
    const bool is_known = element_->name == "vertex" || element_->name == "face";
    return is_known ? element_->name : quoted(element_->name);
  }
  [[nodiscard]] Error refuse(std::string reason, std::string what) const {
    return here(invalid_argument(std::move(reason), std::move(what)));
  }
  [[nodiscard]] Status added(const Status& status) const { return status.ok() ? status : Status(here(status.error())); }

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
    if (element_->name == "face") return added(faces_.add_face(corners_));
    if (element_->name != "vertex") return Nothing{};
    if (header_.has_texture) {
      KERF_TRY(added(faces_.add_texture(texture)));
    }
    return added(faces_.add_position(position));
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
        return read_number(property.type, position.x());
      case PlyRole::kY:
        return read_number(property.type, position.y());
      case PlyRole::kZ:
        return read_number(property.type, position.z());
      case PlyRole::kTextureX:
        return read_number(property.type, texture.x());
      case PlyRole::kTextureY:
        return read_number(property.type, texture.y());
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
    corners_.clear();
    if (length > kMaxFaceCorners) return refuse("FACE", "more than " + std::to_string(kMaxFaceCorners) + " corners");
    for (std::uint64_t i = 0; i < length; ++i) {
      double index = 0.0;
      KERF_TRY(read_number(property.type, index));
      if (!(index >= 0.0 && index < static_cast<double>(header_.num_vertices) && index == std::floor(index))) {
        return refuse("INDEX", "a corner must name one of the " + std::to_string(header_.num_vertices) + " vertices");
      }
      const auto vertex = static_cast<std::int32_t>(index);
      corners_.emplace_back(vertex, header_.has_texture ? vertex : kNone);
    }
    return Nothing{};
  }

  Status read_number(PlyType type, double& value) {
    if (is_text()) {
      const std::string_view word = next_token(row_text_);
      if (word.empty()) return too_few();
      if (!parse_number(word, value)) return refuse("NUMBER", quoted(word) + " is not a number");
      return Nothing{};
    }
    const std::size_t size = size_of(type);
    if (file_.size() < size) return truncated();
    value = decode(type, file_.substr(0, size), header_.format == PlyFormat::kBigEndian);
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
  std::vector<FaceList::Corner> corners_;
  FaceList faces_{0};
};

}  // namespace

Result<ImportedSheet> parse_ply(std::string_view file, RestShape rest_shape) {
  return PlyReader(file).run(rest_shape);
}

}  // namespace kerf::mesh
