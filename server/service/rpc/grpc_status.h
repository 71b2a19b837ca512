#pragma once

#include <grpcpp/support/status.h>

#include "server/base/result.h"

namespace kerf::rpc {

// With the google.rpc.Status of service/wire/error_codec.h as grpc-status-details-bin. Long messages and fields are
// cut: a trailer must fit the client's metadata limit (8 KiB by default), or the client sees another error than ours.
grpc::Status to_status(const Error& error);

}  // namespace kerf::rpc
