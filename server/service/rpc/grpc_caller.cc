#include "server/service/rpc/grpc_caller.h"

#include <string>
#include <string_view>
#include <utility>

#include "server/service/api/api.h"

namespace kerf::rpc {

std::string address_in(std::string_view peer) {
  if (peer.starts_with("ipv4:")) return std::string(peer.substr(5, peer.rfind(':') - 5));
  constexpr std::string_view kBracket = "ipv6:%5B";
  if (peer.starts_with(kBracket)) {
    return std::string(peer.substr(kBracket.size(), peer.find("%5D") - kBracket.size()));
  }
  return std::string(peer);
}

Result<auth::Caller> caller_of(const api::Api& api, const grpc::CallbackServerContext& context) {
  const auto forwarded = context.client_metadata().find("x-forwarded-for");
  const bool is_named = forwarded != context.client_metadata().end();
  std::string address = api.address_of(
      address_in(context.peer()),
      is_named ? std::string_view(forwarded->second.data(), forwarded->second.size()) : std::string_view());
  const auto [first, last] = context.client_metadata().equal_range("authorization");
  if (first == last) return api.caller_of({}, std::move(address));
  if (std::next(first) != last) {
    return unauthenticated("TOKEN_MISSING", "the metadata `authorization` is there twice; send one token",
                           "authorization");
  }
  return api.caller_of({first->second.data(), first->second.size()}, std::move(address));
}

}  // namespace kerf::rpc
