#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>
#include <grpcpp/support/slice.h>

#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>

#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "server/service/api/stream_session.h"
#include "server/service/rpc/grpc_status.h"
#include "server/service/rpc/write_timeout.h"
#include "server/service/stream/message.h"

namespace kerf::rpc {

// Returns the parts without copying; each slice keeps its part alive until gRPC has sent it.
grpc::ByteBuffer to_byte_buffer(const stream::Message& message);

// Returns the bytes of a request, or nothing if gRPC cannot join them.
std::optional<grpc::Slice> whole(const grpc::ByteBuffer& request);

// Holds the objects shared by all streams of a server. Outlives them.
struct StreamHosting {
  // Threads that encode and write for woken streams, so that the sheet's strand is not blocked.
  boost::asio::thread_pool& writers;
  host::Clock& clock;
  host::Nanoseconds write_timeout;  // A reader that takes no message for this long is cut off without notice.
};

// Writes the messages of a session. Every write starts in advance(), which runs only while it owns `busy_`. Thus at
// most one write is in flight, and no lock is held over a call into gRPC or the session. `Reactor`: a gRPC reactor with
// a stream of responses.
template <typename Reactor>
class SessionReactor : public Reactor {
 public:
  SessionReactor(std::shared_ptr<api::StreamSession> session, grpc::CallbackServerContext& context,
                 StreamHosting& hosting)
      : session_(std::move(session)),
        context_(context),
        hosting_(hosting),
        write_timeout_(std::make_shared<WriteTimeout>(hosting.clock, hosting.write_timeout)) {}

  void OnWriteDone(bool ok) override {
    write_timeout_->write_done();
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
    // stop() and set_wake() wait for a running callback, which uses this object.
    write_timeout_->stop();
    session_->set_wake({});
    session_->close();
    delete this;
  }

 protected:
  // Starts the stream; to be called once, at the end of the most derived constructor.
  void begin() {
    write_timeout_->begin([this] { context_.TryCancel(); });
    session_->set_wake([this] { wake(); });
  }

  // Posts advance() to the writers. The stream is busy until advance() runs, so nothing finishes the stream or deletes
  // this object before.
  void wake() {
    {
      const std::lock_guard lock(mutex_);
      woken_ = true;
      if (std::exchange(busy_, true)) return;
    }
    boost::asio::post(hosting_.writers, [this] { advance(); });
  }

  api::StreamSession& session() { return *session_; }

 private:
  // Starts the next write or finishes the stream, and stays busy until that is done. Becomes idle if there is nothing
  // to do. No member may be touched after StartWrite or Finish, because OnWriteDone or OnDone may have deleted this
  // object.
  void advance() {
    while (true) {
      {
        const std::lock_guard lock(mutex_);
        busy_ = std::exchange(woken_, false);
        if (!busy_) return;
      }
      // Read before next(): once the session has ended, no message is added.
      const bool ended = session_->ended();
      if (const std::optional<stream::Message> message = session_->next()) {
        response_ = to_byte_buffer(*message);
        write_timeout_->write_begun();
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

  const std::shared_ptr<api::StreamSession> session_;
  grpc::CallbackServerContext& context_;  // gRPC keeps it until OnDone has returned.
  StreamHosting& hosting_;
  const std::shared_ptr<WriteTimeout> write_timeout_;  // Its timer may fire after this object is gone.
  grpc::ByteBuffer response_;
  std::mutex mutex_;    // Guards the members below.
  bool busy_ = false;   // advance() runs or is posted, a write is in flight, or the stream is finished.
  bool woken_ = false;  // There may be a message to write.
};

// Serves a bidirectional stream.
class TalkReactor final : public SessionReactor<grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>> {
 public:
  TalkReactor(std::shared_ptr<api::StreamSession> session, grpc::CallbackServerContext& context, StreamHosting& hosting)
      : SessionReactor(std::move(session), context, hosting) {
    begin();
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    const std::optional<grpc::Slice> bytes = ok ? whole(request_) : std::nullopt;
    if (!bytes) {  // The client has finished, or is gone.
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

}  // namespace kerf::rpc
