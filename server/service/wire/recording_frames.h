#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "server/base/result.h"

namespace google::protobuf {
class MessageLite;
}

// Defines the bytes around the messages of a recording file.
//
// Formats 3 and 4 begin with kRecordingSignature. Each message follows a head of kFrameHeadBytes, little-endian: its
// length in bytes (32 bits), its CRC-32C (32 bits), and the lower half of the CRC-32C of these eight bytes (16 bits).
// Every single flipped bit is found, and none makes a file look like one that ends early.
//
// Formats 1 and 2 have each message after its length as a varint, and no checksum: a changed length may look like a
// torn file.
namespace kerf::wire {

inline constexpr std::string_view kRecordingSignature{"\0kerfrec", 8};
inline constexpr std::size_t kFrameHeadBytes = 10;

// Returns the message with its head, as in formats 3 and 4.
std::string recording_frame(const google::protobuf::MessageLite& message);

// Returns a kDataLoss error with the offset in bytes in its message and its field ("offset 1234").
Error recording_damage(const char* reason, std::size_t offset, const std::string& what);
Error recording_too_large(std::size_t offset, const std::string& what, std::int64_t limit);

// Splits a file of any format into messages. `file` must outlive it.
class RecordingReader {
 public:
  // Reads the signature. kDataLoss RECORDING_TRUNCATED: the file ends within it; RECORDING_DAMAGED: it has changed.
  static Result<RecordingReader> open(std::string_view file);

  [[nodiscard]] bool is_checked() const { return is_checked_; }  // True for formats 3 and 4, which have checksums.
  [[nodiscard]] bool done() const { return at_ == file_.size(); }
  // Returns the offset in bytes of the message read last.
  [[nodiscard]] std::size_t offset() const { return start_; }
  [[nodiscard]] std::size_t bytes_from_offset() const { return file_.size() - start_; }

  // Returns the bytes of the next message, or nothing if the file ends within it. kDataLoss RECORDING_DAMAGED: an
  // impossible length or a wrong checksum.
  Result<std::optional<std::string_view>> next();

  // Parses a message given by next(). `unfolding`: how many of its bytes may take many times as much memory. kDataLoss
  // RECORDING_TOO_LARGE, RECORDING_DAMAGED.
  Status parse(std::string_view bytes, std::size_t unfolding, google::protobuf::MessageLite& message) const;

 private:
  RecordingReader(std::string_view file, bool is_checked)
      : file_(file), is_checked_(is_checked), at_(is_checked ? kRecordingSignature.size() : 0) {}

  Result<std::optional<std::string_view>> next_checked();
  Result<std::optional<std::string_view>> next_plain();
  std::optional<std::string_view> take(std::uint64_t length);

  std::string_view file_;
  bool is_checked_;
  std::size_t at_;
  std::size_t start_ = 0;
};

}  // namespace kerf::wire
