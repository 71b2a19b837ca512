#pragma once

#include <grpcpp/server_context.h>

#include <string>
#include <string_view>

#include "server/base/result.h"
#include "server/service/auth/grant.h"

namespace kerf::api {
class Api;
}  // namespace kerf::api

namespace kerf::rpc {

// Returns the address in what gRPC calls a peer, such as "ipv4:192.0.2.7:4711" or "ipv6:%5B::1%5D:4711".
std::string address_in(std::string_view peer);

// Returns who calls, by the metadata `authorization`. Errors: those of api::Api::caller_of(); kUnauthenticated
// TOKEN_MISSING if it is there more than once.
Result<auth::Caller> caller_of(const api::Api& api, const grpc::CallbackServerContext& context);

}  // namespace kerf::rpc
