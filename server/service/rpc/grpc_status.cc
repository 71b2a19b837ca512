#include "server/service/rpc/grpc_status.h"

#include <string>

#include "server/base/text_encoding.h"
#include "server/service/wire/error_codec.h"

namespace kerf::rpc {
namespace {

// Limits on message and field. Both appear in the message and again in the details, base64-encoded.
constexpr std::size_t kMaxMessageBytes = 1000;
constexpr std::size_t kMaxFieldBytes = 200;

}  // namespace

grpc::Status to_status(const Error& error) {
  Error bounded = error;
  bounded.message = shortened(error.message, kMaxMessageBytes);
  bounded.field = shortened(error.field, kMaxFieldBytes);
  return {static_cast<grpc::StatusCode>(wire::status_code(error.code)), bounded.message, wire::encode_status(bounded)};
}

}  // namespace kerf::rpc
