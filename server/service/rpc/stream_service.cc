#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <memory>
#include <utility>

#include "kerf/v1/stream.grpc.pb.h"
#include "server/service/api/api.h"
#include "server/service/api/watch_session.h"
#include "server/service/rpc/grpc_caller.h"
#include "server/service/rpc/grpc_status.h"
#include "server/service/rpc/messages.h"
#include "server/service/rpc/services.h"
#include "server/service/rpc/session_reactor.h"

namespace kerf::rpc {
namespace {

class SubscribeReactor final : public SessionReactor<grpc::ServerWriteReactor<grpc::ByteBuffer>> {
 public:
  SubscribeReactor(std::shared_ptr<api::StreamSession> session, grpc::CallbackServerContext& context,
                   StreamHosting& hosting)
      : SessionReactor(std::move(session), context, hosting) {
    begin();
  }
};

// Refuses a call whose request is malformed.
class RefusedReactor final : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 public:
  explicit RefusedReactor(const Error& error) { Finish(to_status(error)); }
  void OnDone() override { delete this; }
};

using RawStream = v1::StreamService::WithRawCallbackMethod_Watch<
    v1::StreamService::WithRawCallbackMethod_Subscribe<v1::StreamService::Service>>;
class StreamService final : public RawStream {
 public:
  StreamService(api::Api& api, StreamHosting& hosting) : api_(api), hosting_(hosting) {}

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* Watch(grpc::CallbackServerContext* context) override {
    // Deletes itself in OnDone.
    return new TalkReactor(api_.watch(caller_of(api_, *context)), *context, hosting_);
  }
  grpc::ServerWriteReactor<grpc::ByteBuffer>* Subscribe(grpc::CallbackServerContext* context,
                                                        const grpc::ByteBuffer* request) override {
    const Result<v1::SubscribeRequest> message = parse_message<v1::SubscribeRequest>(*request);
    if (!message.ok()) return new RefusedReactor(message.error());
    return new SubscribeReactor(api_.subscribe(*message, caller_of(api_, *context)), *context, hosting_);
  }

 private:
  api::Api& api_;
  StreamHosting& hosting_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_stream_service(api::Api& api, StreamHosting& hosting) {
  return std::make_unique<StreamService>(api, hosting);
}

}  // namespace kerf::rpc
