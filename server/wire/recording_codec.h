#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "server/base/result.h"
#include "server/sheet/recording.h"

// Recording files: a kerf.v1.RecordingHeader, then RecordedTicks, each preceded by its length as a varint.
namespace kerf::wire {

inline constexpr std::int32_t kRecordingFormat = 2;  // written; 1, in which no tick is left out, is read as well

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

// A whole file. kDataLoss, with the offset in bytes in the message and in `field` ("offset 1234"):
//   RECORDING_TRUNCATED  the file ends within a message
//   RECORDING_DAMAGED    a length or a message that cannot be, or a scene or command that is refused
//   RECORDING_FORMAT     not a recording, or of another format version
Result<RecordingFile> decode_recording(std::string_view file);

}  // namespace kerf::wire
