#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>

#include "server/service/api/api.h"

namespace kerf::api {

// What one upload takes of Limits::max_uploading_bytes, until nothing holds it any more.
class UploadRoom {
 public:
  UploadRoom(std::shared_ptr<ApiCore> core, std::int64_t num_bytes);
  ~UploadRoom();
  UploadRoom(const UploadRoom&) = delete;
  UploadRoom& operator=(const UploadRoom&) = delete;

  // By all uploads, when this one came.
  [[nodiscard]] std::int64_t taken_together() const { return together_; }

 private:
  const std::shared_ptr<ApiCore> core_;
  const std::int64_t num_bytes_;
  const std::int64_t together_;
};

// A file that comes in parts, of a length told before. Not thread-safe.
class Upload {
 public:
  // What is done with the whole file; see finish().
  using Use = std::function<void(std::string content, Reply<v1::Sheet> reply, const std::stop_token& stop)>;

  Upload(std::shared_ptr<const UploadRoom> room, std::int64_t num_bytes, Use use)
      : room_(std::move(room)), num_bytes_(num_bytes), use_(std::move(use)) {}

  // kInvalidArgument UPLOAD_LENGTH, where that is more than was told.
  Status append(std::string part);
  // Replies with the sheet that is made of the file, or why there is none: UPLOAD_LENGTH, where parts are missing. At
  // most once, and nothing is appended after it. `stop`: requests one where the client leaves.
  void finish(Reply<v1::Sheet> reply, const std::stop_token& stop = {});

 private:
  std::shared_ptr<const UploadRoom> room_;
  std::int64_t num_bytes_;
  Use use_;
  std::string content_;
};

}  // namespace kerf::api
