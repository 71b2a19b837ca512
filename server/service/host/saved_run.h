#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "server/core/fem/step/integrator.h"
#include "server/service/host/command_result.h"
#include "server/service/host/kept_recording.h"
#include "server/service/host/scene_changes.h"

namespace kerf::host {

// Holds all that decides the future of a live sheet beside its scene, between two ticks. A plain value: nothing of it
// belongs to the runner that it was saved from. Calls that waited for an answer are not part of it.
struct SavedRun {
  std::shared_ptr<const std::string> sheet;  // All that sheet::Sheet::save() wrote; never null.
  std::vector<ScheduledCommand> scheduled;   // Commands that wait for their tick, sorted by tick and number.
  std::int64_t last_schedule_number = 0;     // Last number that Host::schedule() had returned; 0: none.
  SceneChanges changes;
  fem::FlagCounts flagged_ticks{};
  KeptEntries recording;  // The run that led here.
  bool paused = false;
  double speed = 1.0;                     // -, see Host::set_speed()
  std::vector<std::string> stream_grabs;  // Grabs that end with their streams.
  std::string attachment;                 // Bytes of the caller, who alone reads them.

  // Returns the memory that it takes, bytes, counted by sizes and never by capacities.
  [[nodiscard]] std::size_t num_bytes() const {
    return sizeof(SavedRun) + sheet->size() + scheduled.size() * sizeof(ScheduledCommand) + recording.bytes.size() +
           attachment.size();
  }
};

}  // namespace kerf::host
