#include "server/service/api/upload.h"

#include <utility>

#include "server/service/api/core.h"

namespace kerf::api {
namespace {

Error wrong_length(std::int64_t announced, const std::string& came) {
  return invalid_argument("UPLOAD_LENGTH",
                          "start.num_bytes is " + std::to_string(announced) + ", but " + came +
                              " arrived; give the length of the file and send all of it",
                          "start.num_bytes");
}

}  // namespace

UploadRoom::UploadRoom(std::shared_ptr<ApiCore> core, std::int64_t num_bytes)
    : core_(std::move(core)), num_bytes_(num_bytes), together_(core_->uploading_bytes += num_bytes) {}

UploadRoom::~UploadRoom() {
  core_->uploading_bytes -= num_bytes_;
}

Status Upload::append(std::string part) {
  const auto size = static_cast<std::int64_t>(content_.size() + part.size());
  if (size > num_bytes_) return wrong_length(num_bytes_, std::to_string(size) + " bytes or more");
  if (content_.empty()) {
    content_ = std::move(part);
  } else {
    content_ += part;
  }
  return Nothing{};
}

Result<std::unique_ptr<Upload>> recorded_upload(Result<std::unique_ptr<Upload>> upload, const Recorder& record) {
  if (upload.ok()) {
    (*upload)->record_with(record);
  } else if (record) {
    record(upload.error(), {});
  }
  return upload;
}

void Upload::finish(Reply<v1::Sheet> reply, const std::stop_token& stop) {
  const auto size = static_cast<std::int64_t>(content_.size());
  const auto answer = [room = room_, record = record_, reply = std::move(reply)](Result<v1::Sheet> sheet) {
    if (record) record(sheet.ok() ? Status(Nothing{}) : Status(sheet.error()), sheet.ok() ? id_of(*sheet) : "");
    reply(std::move(sheet));
  };
  if (size < num_bytes_) return answer(wrong_length(num_bytes_, "only " + std::to_string(size) + " bytes"));
  use_(std::move(content_), answer, stop);
}

}  // namespace kerf::api
