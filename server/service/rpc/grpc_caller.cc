#include "server/service/rpc/grpc_caller.h"

#include <string_view>

#include "server/service/api/api.h"

namespace kerf::rpc {

Result<auth::Caller> caller_of(const api::Api& api, const grpc::CallbackServerContext& context) {
  const auto [first, last] = context.client_metadata().equal_range("authorization");
  if (first == last) return api.caller_of({}, context.peer());
  if (std::next(first) != last) {
    return unauthenticated("TOKEN_MISSING", "the metadata `authorization` is there twice; send one token",
                           "authorization");
  }
  return api.caller_of({first->second.data(), first->second.size()}, context.peer());
}

}  // namespace kerf::rpc
