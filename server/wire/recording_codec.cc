#include "server/wire/recording_codec.h"

#include <limits>
#include <optional>
#include <utility>

#include "kerf/v1/run.pb.h"
#include "server/wire/command_codec.h"
#include "server/wire/scene_codec.h"

namespace kerf::wire {
namespace {

constexpr std::string_view kMagic = "kerf-recording";

std::string delimited(const google::protobuf::MessageLite& message) {
  std::string bytes;
  std::uint64_t length = message.ByteSizeLong();
  while (length >= 0x80) {
    bytes.push_back(static_cast<char>((length & 0x7f) | 0x80));
    length >>= 7;
  }
  bytes.push_back(static_cast<char>(length));
  message.AppendToString(&bytes);
  return bytes;
}

Error damage(const char* reason, std::size_t offset, const std::string& what) {
  const std::string at = "offset " + std::to_string(offset);
  return {ErrorCode::kDataLoss, reason, "recording, " + at + ": " + what, at};
}

// Takes the messages of a file apart.
class Reader {
 public:
  explicit Reader(std::string_view file) : file_(file) {}

  [[nodiscard]] bool done() const { return at_ == file_.size(); }
  // Where the message read last begins.
  [[nodiscard]] std::size_t offset() const { return start_; }

  Status next(google::protobuf::MessageLite& message) {
    start_ = at_;
    std::uint64_t length = 0;
    for (int shift = 0;; shift += 7) {
      if (at_ == file_.size()) return damage("RECORDING_TRUNCATED", start_, "the file ends within a length");
      if (shift > 28) return damage("RECORDING_DAMAGED", start_, "a length of more than five bytes");
      const auto byte = static_cast<unsigned char>(file_[at_++]);
      length |= std::uint64_t{byte & 0x7fU} << shift;
      if (byte < 0x80) break;
    }
    if (length > file_.size() - at_) {
      return damage("RECORDING_TRUNCATED", start_,
                    "the file ends within a message of " + std::to_string(length) + " bytes");
    }
    const bool parsed = length <= std::uint64_t{std::numeric_limits<int>::max()} &&
                        message.ParseFromArray(file_.data() + at_, static_cast<int>(length));
    if (!parsed) return damage("RECORDING_DAMAGED", start_, "what is there is no message of a recording");
    at_ += static_cast<std::size_t>(length);
    return Nothing{};
  }

 private:
  std::string_view file_;
  std::size_t at_ = 0;
  std::size_t start_ = 0;
};

Result<sheet::RecordedTick> decode_tick(const v1::RecordedTick& message, std::size_t offset) {
  sheet::RecordedTick tick;
  tick.tick = message.tick();
  tick.state_hash = message.state_hash();
  for (int i = 0; i < message.commands_size(); ++i) {
    Result<sheet::Command> command = decode_command(message.commands(i));
    if (!command.ok()) {
      return damage("RECORDING_DAMAGED", offset,
                    "command " + std::to_string(i) + " is refused: " + command.error().message);
    }
    tick.commands.push_back(std::move(*command));
  }
  return tick;
}

}  // namespace

std::string build_name() {
#ifdef __OPTIMIZE__
  return std::string("g++ ") + __VERSION__ + ", optimised";
#else
  return std::string("g++ ") + __VERSION__ + ", not optimised";
#endif
}

std::string encode_recording_header(const sheet::SheetConfig& config, std::string_view build) {
  v1::RecordingHeader header;
  header.set_magic(std::string(kMagic));
  header.set_format_version(kRecordingFormat);
  header.set_build(std::string(build));
  *header.mutable_scene() = encode_scene(config);
  return delimited(header);
}

std::string encode_recorded_tick(const sheet::RecordedTick& tick) {
  v1::RecordedTick message;
  message.set_tick(tick.tick);
  message.set_state_hash(tick.state_hash);
  for (const sheet::Command& command : tick.commands) *message.add_commands() = encode_command(command);
  return delimited(message);
}

Result<RecordingFile> decode_recording(std::string_view file) {
  Reader reader(file);
  v1::RecordingHeader header;
  const Status status = reader.next(header);
  if (!status.ok() && status.error().reason == "RECORDING_TRUNCATED") return status.error();
  if (!status.ok() || header.magic() != kMagic) {
    return damage("RECORDING_FORMAT", 0, "this is no Kerf recording");
  }
  if (header.format_version() < 1 || header.format_version() > kRecordingFormat) {
    return damage("RECORDING_FORMAT", 0,
                  "format version " + std::to_string(header.format_version()) + "; this program reads versions 1 to " +
                      std::to_string(kRecordingFormat));
  }
  RecordingFile decoded;
  decoded.build = header.build();
  Result<sheet::SheetConfig> config = decode_scene(header.scene());
  if (!config.ok()) return damage("RECORDING_DAMAGED", 0, "the scene is refused: " + config.error().message);
  decoded.recording.config = std::move(*config);
  while (!reader.done()) {
    v1::RecordedTick message;
    if (const Status next = reader.next(message); !next.ok()) return next.error();
    Result<sheet::RecordedTick> tick = decode_tick(message, reader.offset());
    if (!tick.ok()) return tick.error();
    decoded.recording.entries.push_back(std::move(*tick));
  }
  return decoded;
}

}  // namespace kerf::wire
