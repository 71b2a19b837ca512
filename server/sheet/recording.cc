#include "server/sheet/recording.h"

namespace kerf::sheet {

void Recorder::start(const SheetConfig& config) {
  recording_.config = config;
  recording_.entries.clear();
}

void Recorder::append(const RecordedTick& entry) {
  recording_.entries.push_back(entry);
}

Result<ReplayReport> replay(const Recording& recording) {
  Result<Sheet> created = Sheet::create(recording.config);
  if (!created) return created.error();
  Sheet& sheet = *created;
  ReplayReport report;
  for (std::size_t i = 0; i < recording.entries.size(); ++i) {
    const RecordedTick& entry = recording.entries[i];
    if (entry.tick != sheet.tick() && entry.tick != sheet.tick() + 1) {
      return Error{ErrorCode::kDataLoss, "RECORDING_ORDER",
                   "entry " + std::to_string(i) + " is of tick " + std::to_string(entry.tick) + "; expected " +
                       std::to_string(sheet.tick()) + " or " + std::to_string(sheet.tick() + 1),
                   ""};
    }
    if (entry.tick == sheet.tick()) {
      sheet.apply(entry.commands);
    } else {
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
