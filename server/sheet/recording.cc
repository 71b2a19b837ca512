#include "server/sheet/recording.h"

namespace kerf::sheet {

void Recorder::start(const SheetConfig& config) {
  recording_.config = config;
  recording_.entries.clear();
}

void Recorder::append(const RecordedTick& entry) {
  recording_.entries.push_back(entry);
}

Status check_order(std::span<const RecordedTick> entries) {
  std::int64_t before = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::int64_t tick = entries[i].tick;
    if (tick < before || tick - before > kMaxRecordedGap) {
      return Error{ErrorCode::kDataLoss, "RECORDING_ORDER",
                   "entry " + std::to_string(i) + " is of tick " + std::to_string(tick) + "; expected " +
                       std::to_string(before) + " to " + std::to_string(before + kMaxRecordedGap),
                   ""};
    }
    before = tick;
  }
  return Nothing{};
}

Result<ReplayReport> replay(const Recording& recording) {
  if (Status s = check_order(recording.entries); !s) return s.error();
  Result<Sheet> created = Sheet::create(recording.config);
  if (!created) return created.error();
  Sheet& sheet = *created;
  ReplayReport report;
  for (std::size_t i = 0; i < recording.entries.size(); ++i) {
    const RecordedTick& entry = recording.entries[i];
    if (entry.tick == sheet.tick()) {
      sheet.apply(entry.commands);
    } else {
      // A sheet that freezes on the way stays where it is, and then differs.
      for (std::int64_t t = sheet.tick() + 1; t < entry.tick; ++t) sheet.step({});
      sheet.step(entry.commands);
    }
    const std::uint64_t hash = sheet.state_hash();
    if (hash != entry.state_hash || sheet.tick() != entry.tick) {
      report.divergence = Divergence{i, entry.tick, entry.state_hash, hash, sheet.tick()};
      break;
    }
    report.ticks = sheet.tick();
  }
  return report;
}

}  // namespace kerf::sheet
