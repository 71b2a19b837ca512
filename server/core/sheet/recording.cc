#include "server/core/sheet/recording.h"

namespace kerf::sheet {

void Recorder::start(const scene::SheetConfig& config) {
  recording_.config = config;
  recording_.entries.clear();
}

void Recorder::append(const RecordedTick& entry) {
  recording_.entries.push_back(entry);
}

Status check_next(const RecordedTick& entry, std::size_t index, std::int64_t before) {
  const std::int64_t earliest = entry.commands.empty() ? before + 1 : before;
  if (entry.tick < earliest || entry.tick - before > kMaxRecordedGap) {
    return data_loss("RECORDING_ORDER", "entry " + std::to_string(index) + " is of tick " + std::to_string(entry.tick) +
                                            "; expected " + std::to_string(earliest) + " to " +
                                            std::to_string(before + kMaxRecordedGap));
  }
  if (entry.commands.size() > kMaxTickCommands) {
    return data_loss("RECORDING_TICK", "entry " + std::to_string(index) + " has " +
                                           std::to_string(entry.commands.size()) + " commands; at most " +
                                           std::to_string(kMaxTickCommands) + " are allowed in one tick");
  }
  return Nothing{};
}

Status check_order(std::span<const RecordedTick> entries) {
  std::int64_t before = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    KERF_TRY(check_next(entries[i], i, before));
    before = entries[i].tick;
  }
  return Nothing{};
}

Result<ReplayReport> replay(const Recording& recording) {
  KERF_TRY(check_order(recording.entries));
  KERF_TRY_ASSIGN(Sheet sheet, Sheet::create(recording.config));
  ReplayReport report;
  for (std::size_t i = 0; i < recording.entries.size(); ++i) {
    const RecordedTick& entry = recording.entries[i];
    if (entry.tick == sheet.tick()) {
      sheet.apply(entry.commands);
    } else {
      // If the sheet freezes on the way, these steps do not advance it, and its tick then differs.
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
