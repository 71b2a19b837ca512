#pragma once

#include "server/base/result.h"

namespace google::protobuf {
class Message;
}  // namespace google::protobuf

namespace kerf::wire {

// Refuses a request with a number that is NaN or infinite anywhere in it, also where nothing would read it:
// kInvalidArgument NOT_FINITE, in a curve CURVE_NOT_FINITE and in an inline mesh MESH_NOT_FINITE, with the path of the
// first one as the field. Its type must not be recursive.
// Thread-safe.
Status check_finite(const google::protobuf::Message& request);

}  // namespace kerf::wire
