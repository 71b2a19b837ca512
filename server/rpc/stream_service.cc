#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>
#include <grpcpp/support/slice.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "kerf/v1/stream.grpc.pb.h"
#include "server/api/api.h"
#include "server/api/watch_session.h"
#include "server/rpc/grpc_status.h"
#include "server/rpc/services.h"
#include "server/stream/message.h"

namespace kerf::rpc {
namespace {

// The parts' own bytes, each kept alive by its slice until gRPC has sent it.
grpc::ByteBuffer to_byte_buffer(const stream::Message& message) {
  std::vector<grpc::Slice> slices;
  slices.reserve(message.parts.size());
  for (const stream::Bytes& part : message.parts) {
    // gRPC's signature is not const; it only reads.
    slices.emplace_back(
        const_cast<char*>(part->data()), part->size(), [](void* kept) { delete static_cast<stream::Bytes*>(kept); },
        new stream::Bytes(part));
  }
  return {slices.data(), slices.size()};
}

// Writes what a session gives. Every write starts in advance(), which only the owner of `busy_` runs: at most one write
// is in flight, and no lock is held over a call into gRPC or the session. `Reactor`: with a stream of responses.
template <typename Reactor>
class SessionReactor : public Reactor {
 public:
  explicit SessionReactor(std::shared_ptr<api::WatchSession> session) : session_(std::move(session)) {}

  void OnWriteDone(bool ok) override {
    if (!ok) session_->close();
    {
      const std::lock_guard lock(mutex_);
      woken_ = true;
    }
    advance();
  }

  void OnCancel() override {
    session_->close();
    wake();
  }

  void OnDone() override {
    session_->set_ready({});  // waits for one that is running: it uses this object
    session_->close();
    delete this;
  }

 protected:
  // To be called once, at the end of the most derived constructor.
  void begin() {
    session_->set_ready([this] { wake(); });
  }

  void wake() {
    {
      const std::lock_guard lock(mutex_);
      woken_ = true;
      if (busy_) return;
      busy_ = true;
    }
    advance();
  }

  api::WatchSession& session() { return *session_; }

 private:
  // Starts the next write or finishes the stream, and stays busy until that is done; idle if there is neither. Nothing
  // of this object may be touched after StartWrite or Finish: their reactions may have deleted it.
  void advance() {
    while (true) {
      {
        const std::lock_guard lock(mutex_);
        busy_ = std::exchange(woken_, false);
        if (!busy_) return;
      }
      // Asked before next(): what is there once the session has ended is all there will be.
      const bool ended = session_->ended();
      if (const std::optional<stream::Message> message = session_->next()) {
        response_ = to_byte_buffer(*message);
        this->StartWrite(&response_);
        return;
      }
      if (ended) {
        const std::optional<Error> failure = session_->failure();
        this->Finish(failure ? to_status(*failure) : grpc::Status::OK);
        return;
      }
    }
  }

  const std::shared_ptr<api::WatchSession> session_;
  grpc::ByteBuffer response_;
  std::mutex mutex_;    // of what follows
  bool busy_ = false;   // somebody runs advance(), or a write is in flight, or the stream is finished
  bool woken_ = false;  // there may be something to write
};

// The bytes of a request, or nothing where gRPC cannot put them together.
std::optional<grpc::Slice> whole(const grpc::ByteBuffer& request) {
  grpc::Slice bytes;
  if (!request.TrySingleSlice(&bytes).ok() && !request.DumpToSingleSlice(&bytes).ok()) return std::nullopt;
  return bytes;
}

class WatchReactor final : public SessionReactor<grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>> {
 public:
  explicit WatchReactor(api::Api& api) : SessionReactor(api.watch()) {
    begin();
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    const std::optional<grpc::Slice> bytes = ok ? whole(request_) : std::nullopt;
    if (!bytes) {  // the client has finished, or is gone
      session().close();
      wake();
      return;
    }
    session().on_bytes({reinterpret_cast<const char*>(bytes->begin()), bytes->size()});
    if (!session().ended()) StartRead(&request_);
    wake();
  }

 private:
  grpc::ByteBuffer request_;
};

class SubscribeReactor final : public SessionReactor<grpc::ServerWriteReactor<grpc::ByteBuffer>> {
 public:
  explicit SubscribeReactor(std::shared_ptr<api::WatchSession> session) : SessionReactor(std::move(session)) {
    begin();
  }
};

// A call whose request is no message.
class RefusedReactor final : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 public:
  explicit RefusedReactor(const Error& error) { Finish(to_status(error)); }
  void OnDone() override { delete this; }
};

using RawStream = v1::StreamService::WithRawCallbackMethod_Watch<
    v1::StreamService::WithRawCallbackMethod_Subscribe<v1::StreamService::Service>>;
class StreamService final : public RawStream {
 public:
  explicit StreamService(api::Api& api) : api_(api) {}

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* Watch(grpc::CallbackServerContext*) override {
    return new WatchReactor(api_);  // deletes itself in OnDone
  }
  grpc::ServerWriteReactor<grpc::ByteBuffer>* Subscribe(grpc::CallbackServerContext*,
                                                        const grpc::ByteBuffer* request) override {
    v1::SubscribeRequest message;
    const std::optional<grpc::Slice> bytes = whole(*request);
    if (!bytes || !message.ParseFromArray(bytes->begin(), static_cast<int>(bytes->size()))) {
      return new RefusedReactor(
          invalid_argument("MALFORMED_MESSAGE", "this is no serialised kerf.v1.SubscribeRequest"));
    }
    return new SubscribeReactor(api_.subscribe(message));
  }

 private:
  api::Api& api_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_stream_service(api::Api& api) {
  return std::make_unique<StreamService>(api);
}

}  // namespace kerf::rpc
