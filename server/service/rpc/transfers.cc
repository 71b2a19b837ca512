#include "server/service/rpc/transfers.h"

#include <algorithm>
#include <memory>
#include <sstream>
#include <stop_token>
#include <string>
#include <utility>

#include "kerf/v1/sheets.pb.h"
#include "server/service/api/access.h"
#include "server/service/api/upload.h"
#include "server/service/host/wake_callback.h"
#include "server/service/rpc/grpc_caller.h"
#include "server/service/rpc/grpc_status.h"
#include "server/service/rpc/messages.h"
#include "server/service/rpc/transfer_deadline.h"

namespace kerf::rpc {
namespace {

using grpc::ByteBuffer;

constexpr std::size_t kChunkBytes = std::size_t{64} << 10;

// Passes the parts of a file to an upload. `Request`: start, then chunks. `Start`: the function of the Api that begins
// the upload.
template <typename Request, typename Start>
class UploadReactor final : public grpc::ServerReadReactor<ByteBuffer> {
 public:
  UploadReactor(Start start, TransferTiming timing, ByteBuffer* response)
      : start_(std::move(start)),
        response_(response),
        deadline_(std::make_shared<TransferDeadline>(timing.clock, timing.timeouts)) {
    deadline_->begin([this, timeouts = timing.timeouts](TransferDeadline::Timeout timeout) {
      Finish(to_status(late(timeout, timeouts)));
    });
    StartRead(&message_);
  }

  void OnReadDone(bool ok) override {
    if (!deadline_->made_progress()) return;
    if (!ok) return end();
    Result<Request> request = parse_message<Request>(message_);
    const Status taken = request.ok() ? take(std::move(request).value()) : Status(request.error());
    if (!taken.ok()) return refuse(taken.error());
    StartRead(&message_);
  }

  void OnCancel() override { left_.request_stop(); }
  void OnDone() override { delete this; }

 private:
  // Passes a message to the upload. Refuses messages without content, because a client must not extend its deadline
  // without sending bytes.
  Status take(Request request) {
    if (request.kind_case() == Request::KIND_NOT_SET) {
      return invalid_argument("CHOICE_MISSING", "kind must be one of start or chunk", "kind");
    }
    if (request.has_start()) {
      if (upload_) return invalid_argument("UPLOAD_ORDER", "start must come once, as the first message", "start");
      KERF_TRY_ASSIGN(upload_, start_(request.start()));
      return Nothing{};
    }
    if (!upload_) return missing_start();
    if (request.chunk().empty()) return invalid_argument("CHUNK_EMPTY", "a chunk must not be empty", "chunk");
    return upload_->append(std::move(*request.mutable_chunk()));
  }

  // Ends the upload; the client has sent everything, or is gone.
  void end() {
    if (!upload_) return refuse(missing_start());
    if (!deadline_->end()) return;
    // Moved out, since the reply may end the call, and delete this object, before finish() returns.
    const std::unique_ptr<api::Upload> upload = std::move(upload_);
    upload->finish(
        [this](Result<v1::Sheet> sheet) {
          Finish(sheet.ok() ? serialise(*sheet, response_) : to_status(sheet.error()));
        },
        left_.get_token());
  }

  void refuse(const Error& error) {
    if (deadline_->end()) Finish(to_status(error));
  }

  static Error late(TransferDeadline::Timeout timeout, const TransferTimeouts& timeouts) {
    std::ostringstream message;
    if (timeout == TransferDeadline::Timeout::kIdle) {
      message << "no part of the upload arrived for " << host::seconds(timeouts.idle)
              << " s: send all of it again, without a pause";
      return aborted("UPLOAD_STALLED", message.str());
    }
    message << "the upload took longer than " << host::seconds(timeouts.total) << " s: send all of it again, faster";
    return aborted("UPLOAD_TOO_SLOW", message.str());
  }

  static Error missing_start() {
    return invalid_argument("UPLOAD_ORDER", "the first message must be start, which announces the upload", "start");
  }

  Start start_;
  ByteBuffer* response_;  // Owned by gRPC, valid until the call is done.
  ByteBuffer message_;
  std::unique_ptr<api::Upload> upload_;
  std::stop_source left_;                             // Stops when the client leaves.
  const std::shared_ptr<TransferDeadline> deadline_;  // Its timer may fire after this object is gone.
};

template <typename Request, typename Start>
grpc::ServerReadReactor<ByteBuffer>* receive(Start start, TransferTiming timing, ByteBuffer* response) {
  return new UploadReactor<Request, Start>(std::move(start), timing, response);  // Deletes itself in OnDone.
}

// Returns a function that begins an upload which the caller may make.
template <typename Start>
auto begin_allowed(api::Api& api, const grpc::CallbackServerContext& context,
                   Result<std::unique_ptr<api::Upload>> (api::Api::*method)(const Start&)) {
  return [&api, caller = caller_of(api, context), method](const Start& start) -> Result<std::unique_ptr<api::Upload>> {
    KERF_TRY(caller);
    KERF_TRY(api.allow(*caller, start));
    return api::recorded_upload((api.*method)(start), api.recorder(*caller, start));
  };
}

// Sends a file in chunks, one write at a time.
class RecordingReactor final : public grpc::ServerWriteReactor<ByteBuffer> {
 public:
  RecordingReactor(api::Api& api, TransferTiming timing, grpc::CallbackServerContext& context, const ByteBuffer* bytes)
      : deadline_(std::make_shared<TransferDeadline>(timing.clock, timing.timeouts)) {
    // Cancels a stalled write, which then ends in OnWriteDone, and with it the call.
    too_slow_->set([&context] { context.TryCancel(); });
    const Result<v1::GetSheetRecordingRequest> request = parse_message<v1::GetSheetRecordingRequest>(*bytes);
    const Result<auth::Caller> caller = caller_of(api, context);
    Status allowed = caller.ok() ? Status(Nothing{}) : Status(caller.error());
    if (allowed.ok() && !request.ok()) allowed = request.error();
    if (allowed.ok()) allowed = api.allow(*caller, *request);
    if (!allowed.ok()) {
      Finish(to_status(allowed.error()));
      return;
    }
    api.get_sheet_recording(*request, [this](Result<std::shared_ptr<const std::string>> file) {
      if (!file.ok()) return Finish(to_status(file.error()));
      file_ = std::move(file).value();
      deadline_->begin([too_slow = too_slow_](TransferDeadline::Timeout) { too_slow->call(); });
      write_next();
    });
  }

  void OnWriteDone(bool ok) override {
    if (!ok || !deadline_->made_progress()) return Finish(grpc::Status::CANCELLED);
    write_next();
  }

  void OnDone() override {
    deadline_->end();
    too_slow_->set({});  // Waits for a running callback, which uses the call.
    delete this;
  }

 private:
  void write_next() {
    if (sent_ == file_->size()) return Finish(grpc::Status::OK);
    v1::RecordingChunk chunk;
    chunk.set_content(file_->substr(sent_, kChunkBytes));
    sent_ += chunk.content().size();
    if (const grpc::Status status = serialise(chunk, &message_); !status.ok()) return Finish(status);
    StartWrite(&message_);
  }

  const std::shared_ptr<TransferDeadline> deadline_;  // Its timer may fire after this object is gone.
  // May be called after this object is gone.
  const std::shared_ptr<host::WakeCallback> too_slow_ = std::make_shared<host::WakeCallback>();
  std::shared_ptr<const std::string> file_;
  std::size_t sent_ = 0;
  ByteBuffer message_;
};

}  // namespace

grpc::ServerReadReactor<ByteBuffer>* receive_sheet(api::Api& api, TransferTiming timing,
                                                   const grpc::CallbackServerContext& context, ByteBuffer* response) {
  return receive<v1::UploadSheetRequest>(begin_allowed(api, context, &api::Api::upload_sheet), timing, response);
}

grpc::ServerReadReactor<ByteBuffer>* receive_recording(api::Api& api, TransferTiming timing,
                                                       const grpc::CallbackServerContext& context,
                                                       ByteBuffer* response) {
  return receive<v1::ReplayRecordingRequest>(begin_allowed(api, context, &api::Api::replay_recording), timing,
                                             response);
}

grpc::ServerWriteReactor<ByteBuffer>* send_recording(api::Api& api, TransferTiming timing,
                                                     grpc::CallbackServerContext& context, const ByteBuffer* request) {
  return new RecordingReactor(api, timing, context, request);  // Deletes itself in OnDone.
}

}  // namespace kerf::rpc
