#pragma once

#include <string_view>

#include "server/base/result.h"

namespace google::protobuf {
class Descriptor;
}  // namespace google::protobuf

namespace kerf::wire {

// Checks JSON text against a message type without building a message, because Protocol Buffers' own parser reports
// neither line nor column. Errors as in from_json(). The type limits how deeply the text may nest, so it must not be
// recursive.
Status check_json(std::string_view json, const google::protobuf::Descriptor& type);

}  // namespace kerf::wire
