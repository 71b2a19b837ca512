#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include "server/base/result.h"
#include "server/core/sheet/recording.h"

// Encodes and decodes recording files: a kerf.v1.RecordingHeader, then RecordedTicks. recording_frames.h has the bytes
// around them.
namespace kerf::wire {

// Version of the format that is written. Versions 1, in which no tick is left out, and 2 can be read, too. Version 3 is
// written for sheets whose automatic integrator is scene::kFirstChoice, which all files of versions 1 to 3 have.
inline constexpr std::int32_t kRecordingFormat = 4;

// Returns the compiler of this build, its version, and whether it optimised.
std::string build_name();
// Returns the start of a recording file. `build`: see build_name(); a replay gives equal bits only on an equal build.
std::string encode_recording_header(const scene::SheetConfig& config, std::string_view build);
// Returns the bytes that each tick appends.
std::string encode_recorded_tick(const sheet::RecordedTick& tick);

struct RecordingFile {
  std::string build;
  sheet::Recording recording;
};

// Limit on one message: a tick, or the header without the text or numbers of its mesh. Decoding a message may take a
// hundred times as much memory as its bytes.
inline constexpr std::size_t kMaxRecordedMessageBytes = std::size_t{8} << 20;

// Limits how much of a file is read into memory, independent of its length. Trusted files need no limits.
struct RecordingLimits {
  std::int64_t max_entries = std::numeric_limits<std::int64_t>::max();
  // Commands; each cut of a batch, subpath and segment of a path, and region of pins counts as one more.
  std::int64_t max_parts = std::numeric_limits<std::int64_t>::max();
};

// Decodes a file up to its last whole entry. If it ends within an entry, Recording::torn_bytes is set. kDataLoss, with
// the offset in bytes in the message and in `field` ("offset 1234"):
//   RECORDING_TRUNCATED  the file ends within its header
//   RECORDING_DAMAGED    a wrong checksum, an impossible length or message, or a refused scene or command
//   RECORDING_FORMAT     not a recording, or of another format version
//   RECORDING_ORDER, RECORDING_TICK  see sheet::check_next
//   RECORDING_TOO_LARGE  a message beyond kMaxRecordedMessageBytes, or more than `limits` allow
Result<RecordingFile> decode_recording(std::string_view file, const RecordingLimits& limits = {});

}  // namespace kerf::wire
