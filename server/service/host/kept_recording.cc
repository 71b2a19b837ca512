#include "server/service/host/kept_recording.h"

namespace kerf::host {

void KeptRecording::append(const sheet::RecordedTick& entry) {
  if (!is_kept()) return;
  const std::string encoded = encode_(entry);
  if (entries_.bytes.size() + encoded.size() > max_bytes_) {
    entries_.given_up_at = entry.tick;
    std::string().swap(entries_.bytes);
    return;
  }
  entries_.bytes += encoded;
  entries_.last_tick = entry.tick;
}

Result<std::string> KeptRecording::until(std::int64_t tick, std::uint64_t state_hash) const {
  if (!encode_) {
    return failed_precondition("RECORDING_NOT_KEPT", "this server keeps no recordings of its sheets");
  }
  if (entries_.given_up_at >= 0) {
    return failed_precondition(
        "RECORDING_TOO_LONG",
        "the recording of this sheet was dropped at tick " + std::to_string(entries_.given_up_at) +
            ", when it exceeded " + std::to_string(max_bytes_) +
            " bytes; create the sheet again, or start kerfd with --record, which writes recordings to disk");
  }
  return tick > entries_.last_tick ? entries_.bytes + encode_({tick, {}, state_hash}) : entries_.bytes;
}

}  // namespace kerf::host
