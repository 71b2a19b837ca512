#pragma once

#include "server/base/result.h"

namespace google::protobuf {
class Message;
}  // namespace google::protobuf

namespace kerf::wire {

// Refuses a request with a NaN or infinite number anywhere in it, even where it is unused. kInvalidArgument NOT_FINITE,
// in a curve CURVE_NOT_FINITE, in an inline mesh MESH_NOT_FINITE; the field is the path of the first such number. The
// message type must not be recursive. Thread-safe.
Status check_finite(const google::protobuf::Message& request);

}  // namespace kerf::wire
