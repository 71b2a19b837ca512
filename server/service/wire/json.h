#pragma once

#include <string>
#include <string_view>

#include "server/base/result.h"

namespace google::protobuf {
class Message;
}  // namespace google::protobuf

// Converts messages to and from JSON (proto3 JSON mapping, https://protobuf.dev/programming-guides/json/).
namespace kerf::wire {

// Returns one line of JSON. Field names are in snake_case, and fields without presence are printed even with their
// default. As the mapping demands, 64-bit integers are strings and bytes are base64.
std::string to_json(const google::protobuf::Message& message);

// Parses JSON and replaces `message`. Names may be snake_case or lowerCamelCase. NaN and infinities are accepted as the
// strings of the mapping and left to validation. A byte order mark is passed over. Errors, kInvalidArgument, with line,
// column and field path in the message:
//   JSON_SYNTAX, JSON_UNKNOWN_FIELD, JSON_DUPLICATE_FIELD (also a second member of a oneof), JSON_TYPE.
Status from_json(std::string_view json, google::protobuf::Message& message);

}  // namespace kerf::wire
