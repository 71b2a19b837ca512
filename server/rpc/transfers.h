#pragma once

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include "server/host/clock.h"

namespace kerf::api {
class Api;
}  // namespace kerf::api

// The calls of SheetService that are larger than a message: files sent to the server in parts, and fetched in parts.
// Each reactor deletes itself when its call is done.
namespace kerf::rpc {

// How long an upload may stand still: then it is ended with ABORTED, UPLOAD_STALLED.
struct UploadPatience {
  host::Clock& clock;
  host::Nanoseconds limit;
};

grpc::ServerReadReactor<grpc::ByteBuffer>* receive_sheet(api::Api& api, UploadPatience patience,
                                                         grpc::ByteBuffer* response);
grpc::ServerReadReactor<grpc::ByteBuffer>* receive_recording(api::Api& api, UploadPatience patience,
                                                             grpc::ByteBuffer* response);
grpc::ServerWriteReactor<grpc::ByteBuffer>* send_recording(api::Api& api, const grpc::ByteBuffer* request);

}  // namespace kerf::rpc
