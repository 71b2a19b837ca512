#include "server/service/api/watch_stream.h"

#include <functional>
#include <utility>
#include <variant>

#include "server/service/wire/frame_encoder.h"

// Holds the hands of a stream.
namespace kerf::api {
namespace {

// Limit on rejections that the client has not read. A client that reads never reaches it; those of a client that does
// not read would only cost memory.
constexpr std::size_t kMaxUnreadRejections = 256;

}  // namespace

// A hand that is not allowed is rejected as others are; the stream stays.
void WatchStream::refuse(const v1::WatchRequest& request, const Error& error) {
  if (error.reason != "SCOPE_TOO_LOW") return fail(error);
  if (request.has_grab()) {
    record(*core_, caller_, "GrabPoint", sheet_id_, {}, error);
    return reject(request.grab().grab_id(), error);
  }
  if (request.has_drag()) return reject(request.drag().grab_id(), error);
  reject(request.release().grab_id(), error);
}

void WatchStream::submit(const std::string& grab_id, Result<scene::Command> command) {
  if (!command.ok()) return reject(grab_id, command.error());
  core_->host.submit(
      sheet_id_, *command,
      [self = shared_from_this(), grab_id, command = *command](Result<host::CommandResult> result) {
        self->answered(grab_id, command, result.ok() ? Status(Nothing{}) : Status(result.error()));
      },
      nullptr, true);
}

void WatchStream::answered(const std::string& grab_id, const scene::Command& command, const Status& status) {
  const bool grabs = std::holds_alternative<scene::Grab>(command);
  if (grabs || std::holds_alternative<scene::Release>(command)) {
    record(*core_, caller_, grabs ? "GrabPoint" : "ReleasePoint", sheet_id_, {}, status);
  }
  if (!status.ok()) return reject(grab_id, status.error());
  bool too_late = false;
  {
    const std::lock_guard lock(mutex_);
    if (std::holds_alternative<scene::Release>(command)) held_grabs_.erase(grab_id);
    if (grabs) {
      too_late = over();
      if (!too_late) held_grabs_.insert(grab_id);
    }
  }
  if (too_late) core_->host.release_grab(sheet_id_, grab_id);
}

void WatchStream::reject(const std::string& grab_id, const Error& error) {
  bool flooded = false;
  {
    const std::lock_guard lock(mutex_);
    if (over()) return;
    flooded = rejections_.size() == kMaxUnreadRejections;
    if (!flooded) {
      stream::Message message;
      message.parts.push_back(std::make_shared<const std::string>(wire::encode_rejection(grab_id, error)));
      rejections_.push_back(std::move(message));
    }
  }
  if (flooded) {
    return fail(resource_exhausted("TOO_MANY_REJECTIONS",
                                   std::to_string(kMaxUnreadRejections) + " rejections are unread; read the stream"));
  }
  wake_.call();
}

}  // namespace kerf::api
