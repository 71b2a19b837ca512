#pragma once

#include <grpcpp/support/status.h>

#include "server/base/result.h"

namespace kerf::rpc {

// Converts an error, with the google.rpc.Status of service/wire/error_codec.h as grpc-status-details-bin. Long messages
// and fields are cut. A trailer must fit the client's metadata limit (8 KiB by default), or the client sees a different
// error.
grpc::Status to_status(const Error& error);

}  // namespace kerf::rpc
