#pragma once

#include <string>
#include <string_view>

#include "server/base/result.h"

namespace google::protobuf {
class Message;
}  // namespace google::protobuf

// The JSON form of messages (proto3 JSON mapping, https://protobuf.dev/programming-guides/json/).
namespace kerf::wire {

// Field names in snake_case, fields without presence printed even where they have their default; 64-bit integers are
// strings and bytes are base64, as the mapping says. One line.
std::string to_json(const google::protobuf::Message& message);

// Replaces `message`. Names may be snake_case or lowerCamelCase; NaN and infinities are accepted as the strings of the
// mapping and left to validation. Refused, kInvalidArgument, with line, column and field path in the message:
//   JSON_SYNTAX, JSON_UNKNOWN_FIELD, JSON_DUPLICATE_FIELD (also a second member of a oneof), JSON_TYPE.
Status from_json(std::string_view json, google::protobuf::Message& message);

}  // namespace kerf::wire
