#include "server/service/rpc/session_reactor.h"

#include <vector>

namespace kerf::rpc {

grpc::ByteBuffer to_byte_buffer(const stream::Message& message) {
  std::vector<grpc::Slice> slices;
  slices.reserve(message.parts.size());
  for (const stream::Bytes& part : message.parts) {
    // gRPC's parameter is not const, but gRPC only reads the bytes.
    slices.emplace_back(
        const_cast<char*>(part->data()), part->size(), [](void* kept) { delete static_cast<stream::Bytes*>(kept); },
        new stream::Bytes(part));
  }
  return {slices.data(), slices.size()};
}

std::optional<grpc::Slice> whole(const grpc::ByteBuffer& request) {
  grpc::Slice bytes;
  if (!request.TrySingleSlice(&bytes).ok() && !request.DumpToSingleSlice(&bytes).ok()) return std::nullopt;
  return bytes;
}

}  // namespace kerf::rpc
