#include "server/service/offline/replay.h"

#include "server/core/sheet/recording.h"
#include "server/service/wire/recording_codec.h"
#include "server/service/wire/reply_codec.h"

namespace kerf::offline {
namespace {

constexpr std::size_t kMaxRecordingBytes = std::size_t{4} << 30;

}  // namespace

Result<ReplayReport> replay(Disk& disk, const std::string& path,
                            const std::function<void(std::size_t entries)>& begin) {
  KERF_TRY_ASSIGN(const std::string bytes, disk.read_file(path, kMaxRecordingBytes));
  KERF_TRY_ASSIGN(const wire::RecordingFile file, wire::decode_recording(bytes));
  if (begin) begin(file.recording.entries.size());
  KERF_TRY_ASSIGN(const sheet::ReplayReport replayed, sheet::replay(file.recording));

  ReplayReport report;
  report.ticks = replayed.ticks;
  report.torn_bytes = static_cast<std::int64_t>(file.recording.torn_bytes);
  if (replayed.divergence) {
    report.divergence = Divergence{replayed.divergence->tick, wire::encode_hash(replayed.divergence->recorded_hash),
                                   wire::encode_hash(replayed.divergence->replayed_hash)};
  }
  if (!file.recording.entries.empty()) {
    report.state_hash = wire::encode_hash(file.recording.entries.back().state_hash);
  }
  report.recorded_by = file.build;
  report.replayed_by = wire::build_name();
  return report;
}

}  // namespace kerf::offline
