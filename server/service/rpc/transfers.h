#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include "server/service/host/clock.h"
#include "server/service/rpc/transfer_deadline.h"

namespace kerf::api {
class Api;
}  // namespace kerf::api

// Serves the calls of SheetService that exceed a message: files sent to the server in parts, and fetched in parts. Each
// reactor deletes itself when its call is done.
namespace kerf::rpc {

// Limits how long transfers may stall and last. Slower uploads end with ABORTED, UPLOAD_STALLED or UPLOAD_TOO_SLOW. The
// call of a reader that does not take its file is cancelled.
struct TransferTiming {
  host::Clock& clock;
  TransferTimeouts timeouts;
};

grpc::ServerReadReactor<grpc::ByteBuffer>* receive_sheet(api::Api& api, TransferTiming timing,
                                                         const grpc::CallbackServerContext& context,
                                                         grpc::ByteBuffer* response);
grpc::ServerReadReactor<grpc::ByteBuffer>* receive_recording(api::Api& api, TransferTiming timing,
                                                             const grpc::CallbackServerContext& context,
                                                             grpc::ByteBuffer* response);
grpc::ServerWriteReactor<grpc::ByteBuffer>* send_recording(api::Api& api, TransferTiming timing,
                                                           grpc::CallbackServerContext& context,
                                                           const grpc::ByteBuffer* request);

}  // namespace kerf::rpc
