#pragma once

#include <string_view>

#include "server/base/result.h"

namespace google::protobuf {
class Descriptor;
}  // namespace google::protobuf

namespace kerf::wire {

// Reads JSON text against a message type without building anything, because Protocol Buffers' own parser says neither
// line nor column. Errors as from_json() has them. Depth is bounded by the type, which must not be recursive.
Status check_json(std::string_view json, const google::protobuf::Descriptor& type);

}  // namespace kerf::wire
