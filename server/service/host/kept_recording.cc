#include "server/service/host/kept_recording.h"

namespace kerf::host {

void KeptRecording::append(const sheet::RecordedTick& entry) {
  if (!is_kept()) return;
  const std::string encoded = encode_(entry);
  if (bytes_.size() + encoded.size() > max_bytes_) {
    given_up_at_ = entry.tick;
    std::string().swap(bytes_);
    return;
  }
  bytes_ += encoded;
  last_tick_ = entry.tick;
}

Result<std::string> KeptRecording::until(std::int64_t tick, std::uint64_t state_hash) const {
  if (!encode_) {
    return failed_precondition("RECORDING_NOT_KEPT", "this server keeps no recordings of its sheets");
  }
  if (given_up_at_ >= 0) {
    return failed_precondition(
        "RECORDING_TOO_LONG",
        "the recording of this sheet was dropped at tick " + std::to_string(given_up_at_) + ", when it exceeded " +
            std::to_string(max_bytes_) +
            " bytes; create the sheet again, or start kerfd with --record, which writes recordings to disk");
  }
  return tick > last_tick_ ? bytes_ + encode_({tick, {}, state_hash}) : bytes_;
}

}  // namespace kerf::host
