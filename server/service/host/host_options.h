#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "server/core/fem/step/integrator.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/recording.h"
#include "server/core/sheet/sheet.h"
#include "server/service/host/clock.h"
#include "server/service/host/journal.h"
#include "server/service/host/saved_states.h"
#include "server/service/host/sheet_event.h"
#include "server/service/host/tenants.h"

namespace kerf::host {

struct HostOptions {
  std::int32_t workers = 2;  // Threads that step sheets, 1..256.
  // Time after which a worker busy with one tick or call is replaced by a further thread (see Workers). That happens
  // only while other sheets wait and no worker is idle. The time is that of the machine's clock, even if the host has
  // another clock. >= 0; 0: no worker is replaced, so the other sheets wait.
  Nanoseconds long_work = std::chrono::milliseconds(50);
  std::int32_t max_sheets = 64;  // >= 1
  // Load from which new running sheets are refused, see Admission; -, > 0; 0: no limit.
  double max_load = 1.0;
  // Limit on the vertices of all sheets together, those being built, paused or at rest included; >= 1; 0: none. It
  // refuses new sheets only: vertices added by cuts count, but are never refused.
  std::int64_t max_total_vertices = 0;
  std::int32_t max_vertices_per_sheet = scene::kMaxVertices;  // A config's own limit may be lower.
  std::int32_t max_queued_commands = 64;                      // Per sheet, >= 1.
  std::int32_t max_scheduled_commands = 64;  // Per sheet: commands of schedule() that wait for their tick, >= 1.
  std::int32_t max_states_per_sheet = 16;    // Saved states of one sheet, >= 1.
  std::int64_t max_state_bytes = std::int64_t{256} << 20;  // Bytes of the saved states of all sheets, >= 0.
  std::int32_t max_step_ticks = 100'000;                   // Per call of step().
  // Finds the tenants whose sheets have limits of their own; null: there are none.
  FindTenant find_tenant;
  // Returns the destination of a new sheet's recording; null, or a null result: it is not recorded.
  std::function<std::shared_ptr<sheet::RecordingSink>(const std::string& id)> make_recording;
  // Encodes the ticks that sheets keep of their runs, see KeptRecording; null: they keep nothing.
  std::function<std::string(const sheet::RecordedTick&)> encode_tick;
  Journal* journal =
      nullptr;  // Keeps the sheets and their changes, see Journal; must outlive the host. null: none does.
  // Encode what the journal keeps; used only with a journal.
  std::function<std::string(const SheetEvent&)> encode_event;
  std::function<std::string(const scene::SheetConfig&)> encode_scene;
  std::function<std::string(const SavedState&)> encode_state;
  // CPU time of ticks that a restart repeats at most, for each worker; >= 0. The journal gets the state of a sheet that
  // exceeds it, or of those with the most if all together do. A 64th of it for a sheet that is paused or asleep.
  Nanoseconds max_unsaved_cpu = std::chrono::seconds(2);
  std::size_t max_recording_bytes = std::size_t{16} << 20;          // Per sheet, of the ticks that KeptRecording keeps.
  sheet::IntegratorFactory make_integrator = fem::make_integrator;  // Makes the integrators of the sheets.
};

}  // namespace kerf::host
