#include "server/service/wire/recording_frames.h"

#include <google/protobuf/message_lite.h>

#include <algorithm>
#include <limits>

#include "server/base/crc32c.h"
#include "server/service/wire/recording_codec.h"

namespace kerf::wire {
namespace {

constexpr std::size_t kCheckedHeadBytes = 8;  // Bytes of a head covered by its own checksum.

void append_bytes(std::string& bytes, std::uint32_t value, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) bytes.push_back(static_cast<char>(value >> (8 * i) & 0xffU));
}

std::uint32_t read_bytes(std::string_view bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i)
    value |= std::uint32_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
  return value;
}

std::uint32_t head_checksum(std::string_view head) {
  return crc32c(head.substr(0, kCheckedHeadBytes)) & 0xffffU;
}

// True if half of the signature is there, which no file of an older format has.
bool is_nearly_signed(std::string_view file) {
  if (file.size() < kRecordingSignature.size()) return false;
  std::size_t num_equal = 0;
  for (std::size_t i = 0; i < kRecordingSignature.size(); ++i) num_equal += file[i] == kRecordingSignature[i] ? 1 : 0;
  return 2 * num_equal >= kRecordingSignature.size();
}

}  // namespace

std::string recording_frame(const google::protobuf::MessageLite& message) {
  const std::string content = message.SerializeAsString();
  std::string frame;
  frame.reserve(kFrameHeadBytes + content.size());
  append_bytes(frame, static_cast<std::uint32_t>(content.size()), 4);
  append_bytes(frame, crc32c(content), 4);
  append_bytes(frame, head_checksum(frame), 2);
  return frame += content;
}

Error recording_damage(const char* reason, std::size_t offset, const std::string& what) {
  const std::string at = "offset " + std::to_string(offset);
  return data_loss(reason, "recording, " + at + ": " + what, at);
}

Error recording_too_large(std::size_t offset, const std::string& what, std::int64_t limit) {
  return recording_damage("RECORDING_TOO_LARGE", offset, what + "; the limit is " + std::to_string(limit));
}

Result<RecordingReader> RecordingReader::open(std::string_view file) {
  if (file.substr(0, kRecordingSignature.size()) == kRecordingSignature) return RecordingReader(file, true);
  if (kRecordingSignature.substr(0, file.size()) == file) {
    return recording_damage("RECORDING_TRUNCATED", 0, "the file ends before its header");
  }
  if (is_nearly_signed(file)) return recording_damage("RECORDING_DAMAGED", 0, "the first bytes have changed");
  return RecordingReader(file, false);
}

Result<std::optional<std::string_view>> RecordingReader::next() {
  start_ = at_;
  return is_checked_ ? next_checked() : next_plain();
}

Result<std::optional<std::string_view>> RecordingReader::next_checked() {
  const std::optional<std::string_view> head = take(kFrameHeadBytes);
  if (!head) return head;
  if (read_bytes(head->substr(kCheckedHeadBytes)) != head_checksum(*head)) {
    return recording_damage("RECORDING_DAMAGED", start_,
                            "the length of a message has changed: its checksum does not match");
  }
  const std::optional<std::string_view> message = take(read_bytes(head->substr(0, 4)));
  if (message && crc32c(*message) != read_bytes(head->substr(4, 4))) {
    return recording_damage("RECORDING_DAMAGED", start_, "a message has changed: its checksum does not match");
  }
  return message;
}

Result<std::optional<std::string_view>> RecordingReader::next_plain() {
  std::uint64_t length = 0;
  for (int shift = 0;; shift += 7) {
    if (done()) return std::optional<std::string_view>();
    if (shift > 28) return recording_damage("RECORDING_DAMAGED", start_, "a length of more than five bytes");
    const auto byte = static_cast<unsigned char>(file_[at_++]);
    length |= std::uint64_t{byte & 0x7fU} << shift;
    if (byte < 0x80) return take(length);
  }
}

std::optional<std::string_view> RecordingReader::take(std::uint64_t length) {
  if (length > file_.size() - at_) return std::nullopt;
  const std::string_view taken = file_.substr(at_, static_cast<std::size_t>(length));
  at_ += taken.size();
  return taken;
}

Status RecordingReader::parse(std::string_view bytes, std::size_t unfolding,
                              google::protobuf::MessageLite& message) const {
  if (unfolding > kMaxRecordedMessageBytes) {
    return recording_too_large(start_, "a message has " + std::to_string(unfolding) + " bytes",
                               static_cast<std::int64_t>(kMaxRecordedMessageBytes));
  }
  const bool parsed = bytes.size() <= std::size_t{std::numeric_limits<int>::max()} &&
                      message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
  if (!parsed) return recording_damage("RECORDING_DAMAGED", start_, "these bytes are not a message of a recording");
  return Nothing{};
}

}  // namespace kerf::wire
