// Bytes -> a recording file -> scene and entries. Whatever the bytes, the answer is a value, no larger than it may be;
// what was read is written as a file that reads the same. Files of formats 1 and 2 get past the frames: no checksums.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/base/check.h"
#include "server/core/sheet/recording.h"
#include "server/service/wire/recording_codec.h"

namespace {

using namespace kerf;

constexpr wire::RecordingLimits kLimits{.max_entries = 8, .max_parts = 16};

std::string encode(const wire::RecordingFile& file) {
  std::string bytes = wire::encode_recording_header(file.recording.config, file.build);
  for (const sheet::RecordedTick& entry : file.recording.entries) bytes += wire::encode_recorded_tick(entry);
  return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Result<wire::RecordingFile> file = wire::decode_recording({reinterpret_cast<const char*>(data), size}, kLimits);
  if (!file.ok()) {
    KERF_CHECK(file.error().code == ErrorCode::kDataLoss, "it is the file that is wrong");
    KERF_CHECK(!file.error().reason.empty() && !file.error().field.empty(), "a refusal says what and where");
    return 0;
  }
  KERF_CHECK(static_cast<std::int64_t>(file->recording.entries.size()) <= kLimits.max_entries, "no more entries");
  KERF_CHECK(sheet::check_order(file->recording.entries).ok(), "in order");
  const std::string encoded = encode(*file);
  const Result<wire::RecordingFile> again = wire::decode_recording(encoded, kLimits);
  KERF_CHECK(again.ok() && encode(*again) == encoded, "an accepted file is accepted again, and the same");
  return 0;
}
