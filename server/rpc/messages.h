#pragma once

#include <grpcpp/impl/codegen/proto_utils.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/proto_buffer_reader.h>
#include <grpcpp/support/proto_buffer_writer.h>

#include <string>

#include "server/base/result.h"

// Messages as the bytes that gRPC moves.
namespace kerf::rpc {

// kInvalidArgument MALFORMED_MESSAGE.
template <typename Message>
Result<Message> parse_message(const grpc::ByteBuffer& bytes) {
  Message message;
  grpc::ByteBuffer copy = bytes;  // shares the bytes; parsing takes them
  if (grpc::SerializationTraits<Message>::Deserialize(&copy, &message).ok()) return message;
  return invalid_argument("MALFORMED_MESSAGE",
                          "this is no serialised " + std::string(Message::descriptor()->full_name()));
}

// In place of whatever `bytes` hold.
template <typename Message>
grpc::Status serialise(const Message& message, grpc::ByteBuffer* bytes) {
  bytes->Clear();  // gRPC ends the process if there are any, as after a write
  bool own_buffer = false;
  return grpc::SerializationTraits<Message>::Serialize(message, bytes, &own_buffer);
}

}  // namespace kerf::rpc
