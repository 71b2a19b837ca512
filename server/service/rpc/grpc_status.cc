#include "server/service/rpc/grpc_status.h"

#include <string>

#include "server/service/wire/error_codec.h"

namespace kerf::rpc {
namespace {

// Limits on message and field. Both appear in the message and again in the details, base64-encoded.
constexpr std::size_t kMaxMessageBytes = 1000;
constexpr std::size_t kMaxFieldBytes = 200;

// Shortens a text to `max_bytes`, or less so that no UTF-8 sequence is cut in two, and adds "...".
std::string cut(const std::string& text, std::size_t max_bytes) {
  if (text.size() <= max_bytes) return text;
  std::size_t end = max_bytes;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end) + "...";
}

}  // namespace

grpc::Status to_status(const Error& error) {
  Error bounded = error;
  bounded.message = cut(error.message, kMaxMessageBytes);
  bounded.field = cut(error.field, kMaxFieldBytes);
  return {static_cast<grpc::StatusCode>(wire::status_code(error.code)), bounded.message, wire::encode_status(bounded)};
}

}  // namespace kerf::rpc
