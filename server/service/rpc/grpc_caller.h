#pragma once

#include <grpcpp/server_context.h>

#include "server/base/result.h"
#include "server/service/auth/grant.h"

namespace kerf::api {
class Api;
}  // namespace kerf::api

namespace kerf::rpc {

// Returns who calls, by the metadata `authorization`. Errors: those of api::Api::caller_of(); kUnauthenticated
// TOKEN_MISSING if it is there more than once.
Result<auth::Caller> caller_of(const api::Api& api, const grpc::CallbackServerContext& context);

}  // namespace kerf::rpc
