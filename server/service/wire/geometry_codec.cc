#include "server/service/wire/geometry_codec.h"

#include <utility>

namespace kerf::wire {
Eigen::Vector2d decode_vector(const v1::Vec2& vector) {
  return {vector.x(), vector.y()};
}

Eigen::Vector3d decode_vector(const v1::Vec3& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

void encode_vector(const Eigen::Vector2d& vector, v1::Vec2& message) {
  message.set_x(vector.x());
  message.set_y(vector.y());
}

void encode_vector(const Eigen::Vector3d& vector, v1::Vec3& message) {
  message.set_x(vector.x());
  message.set_y(vector.y());
  message.set_z(vector.z());
}

Result<std::string> read_content(ContentOrFile from, const FileReader& read_file, const std::string& kind,
                                 const std::string& path) {
  if (from.file.empty()) return std::move(from.content);
  const std::string content = path + "." + from.content_field;
  const std::string field = path + ".file";
  if (!read_file) {
    return invalid_argument(
        kind + "_FILE_REFUSED",
        field + " names a file of the server, which only scene files may do; send its content as " + content, field);
  }
  if (!from.content.empty()) {
    return invalid_argument(kind + "_TWICE", content + " and " + field + " are both given; give one of them", field);
  }
  Result<std::string> text = read_file(from.file);
  if (text.ok()) return text;
  Error error = text.error();
  error.field = field;
  return error;
}

Error missing(const std::string& path) {
  return invalid_argument("FIELD_MISSING", path + " must be given", path);
}

Error choice_missing(const std::string& path, const std::string& choices) {
  return invalid_argument("CHOICE_MISSING", path + " must be one of " + choices, path);
}

Error unknown_enum(const std::string& path, int value) {
  return invalid_argument("UNKNOWN_ENUM_VALUE", path + " is " + std::to_string(value) + ", which is not defined", path);
}

Error within(const std::string& prefix, Error error) {
  error.field = error.field.empty() ? prefix : prefix + "." + error.field;
  return error;
}

}  // namespace kerf::wire
