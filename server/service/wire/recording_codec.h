#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include "server/base/result.h"
#include "server/core/sheet/recording.h"

// Recording files: a kerf.v1.RecordingHeader, then RecordedTicks; recording_frames.h has the bytes around them.
namespace kerf::wire {

inline constexpr std::int32_t kRecordingFormat = 3;  // written; 1, in which no tick is left out, and 2 are read as well

// The compiler of this build and whether it optimised.
std::string build_name();
// What a recording file begins with. `build`: version and compiler; equal bits are promised for equal builds.
std::string encode_recording_header(const sheet::SheetConfig& config, std::string_view build);
// What each tick appends.
std::string encode_recorded_tick(const sheet::RecordedTick& tick);

struct RecordingFile {
  std::string build;
  sheet::Recording recording;
};

// Of one message: a tick, or the header but for the text or numbers of its mesh. A message of so many bytes may take a
// hundred times that while it is read.
inline constexpr std::size_t kMaxRecordedMessageBytes = std::size_t{8} << 20;

// What of a file may be read into memory, whatever its length. For files of one's own: all of them.
struct RecordingLimits {
  std::int64_t max_entries = std::numeric_limits<std::int64_t>::max();
  // Commands, each cut of a batch, subpath and segment of a path and region of pins being one more.
  std::int64_t max_parts = std::numeric_limits<std::int64_t>::max();
};

// Reads a file up to its last whole entry. A file that ends within an entry has Recording::torn_bytes.
// kDataLoss, with the offset in bytes in the message and in `field` ("offset 1234"):
//   RECORDING_TRUNCATED  the file ends within its header
//   RECORDING_DAMAGED    a wrong checksum, a length or a message that cannot be, or a scene or command that is refused
//   RECORDING_FORMAT     not a recording, or of another format version
//   RECORDING_ORDER, RECORDING_TICK  see sheet::check_next
//   RECORDING_TOO_LARGE  a message beyond kMaxRecordedMessageBytes, or more than `limits` allow
Result<RecordingFile> decode_recording(std::string_view file, const RecordingLimits& limits = {});

}  // namespace kerf::wire
