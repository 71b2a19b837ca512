#pragma once

#include <grpcpp/impl/codegen/proto_utils.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/proto_buffer_reader.h>
#include <grpcpp/support/proto_buffer_writer.h>

#include <string>

#include "server/base/result.h"
#include "server/service/wire/finite_check.h"

// Converts messages to and from the bytes that gRPC transports.
namespace kerf::rpc {

// Parses a message. kInvalidArgument MALFORMED_MESSAGE; MESSAGE_INCOMPLETE if the call has no whole message; NOT_FINITE
// if it has a number that is not finite. gRPC has already refused messages over its size limit.
template <typename Message>
Result<Message> parse_message(const grpc::ByteBuffer& bytes) {
  const std::string name(Message::descriptor()->full_name());
  if (!bytes.Valid()) {
    return invalid_argument(
        "MESSAGE_INCOMPLETE",
        "incomplete " + name +
            ": its bytes end before their announced length, or that length exceeds this server's limit");
  }
  Message message;
  grpc::ByteBuffer copy = bytes;  // Shares the bytes; parsing consumes them.
  if (!grpc::SerializationTraits<Message>::Deserialize(&copy, &message).ok()) {
    return invalid_argument("MALFORMED_MESSAGE", "this is not a serialised " + name);
  }
  KERF_TRY(wire::check_finite(message));
  return message;
}

// Serialises a message into `bytes`, replacing their content.
template <typename Message>
grpc::Status serialise(const Message& message, grpc::ByteBuffer* bytes) {
  bytes->Clear();  // gRPC aborts the process if any are left, as after a write.
  bool own_buffer = false;
  return grpc::SerializationTraits<Message>::Serialize(message, bytes, &own_buffer);
}

}  // namespace kerf::rpc
