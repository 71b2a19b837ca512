#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>

#include "server/service/api/api.h"

namespace kerf::api {

// Counts one upload against Limits::max_uploading_bytes until it is destroyed.
class UploadRoom {
 public:
  UploadRoom(std::shared_ptr<ApiCore> core, std::int64_t num_bytes);
  ~UploadRoom();
  UploadRoom(const UploadRoom&) = delete;
  UploadRoom& operator=(const UploadRoom&) = delete;

  // Returns the bytes of all uploads when this one began, its own included.
  [[nodiscard]] std::int64_t taken_together() const { return together_; }

 private:
  const std::shared_ptr<ApiCore> core_;
  const std::int64_t num_bytes_;
  const std::int64_t together_;
};

// Collects a file that arrives in parts, of a length declared before. Not thread-safe.
class Upload {
 public:
  // Uses the whole file; see finish().
  using Use = std::function<void(std::string content, Reply<v1::Sheet> reply, const std::stop_token& stop)>;

  Upload(std::shared_ptr<const UploadRoom> room, std::int64_t num_bytes, Use use)
      : room_(std::move(room)), num_bytes_(num_bytes), use_(std::move(use)) {}

  // Appends a part. kInvalidArgument UPLOAD_LENGTH if the file gets longer than declared.
  Status append(std::string part);
  // Replies with the sheet made from the file, or with the error; UPLOAD_LENGTH if parts are missing. To be called at
  // most once, with no append() after it. `stop` is triggered when the client leaves.
  void finish(Reply<v1::Sheet> reply, const std::stop_token& stop = {});
  // Records what becomes of it. To be called before finish().
  void record_with(Recorder record) { record_ = std::move(record); }

 private:
  std::shared_ptr<const UploadRoom> room_;
  std::int64_t num_bytes_;
  Use use_;
  Recorder record_;
  std::string content_;
};

// Has `record` record what becomes of an upload, also if it was refused at its start. Returns the upload.
Result<std::unique_ptr<Upload>> recorded_upload(Result<std::unique_ptr<Upload>> upload, const Recorder& record);

}  // namespace kerf::api
