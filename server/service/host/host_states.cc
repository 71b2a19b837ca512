#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

#include "server/base/catch_exceptions.h"
#include "server/base/interruption.h"
#include "server/base/memory_headroom.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/sheet/saved_sheet.h"
#include "server/service/host/errors.h"
#include "server/service/host/host.h"
#include "server/service/host/promised_bytes.h"
#include "server/service/host/sheet_runner.h"

// Saves and restores states of the sheets of a Host.
namespace kerf::host {

namespace {

Status check_state_id(const std::string& id) {
  if (scene::is_valid_sheet_id(id)) return Nothing{};
  return invalid_argument("STATE_ID", "state_id must match [a-z][a-z0-9-]{0,62}", "state_id");
}

// Counts a load for as long as it exists.
struct LoadPlace {
  explicit LoadPlace(std::atomic<std::int32_t>& loads) : all(loads), number(++loads) {}
  ~LoadPlace() { --all; }
  LoadPlace(const LoadPlace&) = delete;
  LoadPlace& operator=(const LoadPlace&) = delete;

  std::atomic<std::int32_t>& all;
  const std::int32_t number;  // The loads when this one began, itself included.
};

Error too_many_restores() {
  return resource_exhausted("TOO_MANY_RESTORES", "16 saved states are being restored, the limit; try again later");
}

// Returns the state of a sheet whose run was saved just now.
std::shared_ptr<const SavedState> make_state(std::string id, const sheet::Sheet& sheet, SavedRun run,
                                             std::int64_t unix_us) {
  auto state = std::make_shared<SavedState>();
  const sheet::SavedHeader header = sheet::read_saved_header(*run.sheet).value();
  state->status.id = std::move(id);
  state->status.tick = header.tick;
  state->status.scene_tick = sheet.scene_tick();
  state->status.num_vertices = sheet.mesh().num_vertices();
  state->status.num_bytes = static_cast<std::int64_t>(run.num_bytes());
  state->status.state_hash = header.state_hash;
  state->status.continuation_hash = header.continuation_hash;
  state->status.saved_unix_us = unix_us;
  state->config = sheet.shared_config();
  state->run = std::move(run);
  return state;
}

}  // namespace

void Host::save_state(const std::string& id, std::string state_id, bool overwrite, std::function<std::string()> attach,
                      Callback<SavedStateStatus> done) {
  if (const Status valid = check_state_id(state_id); !valid.ok()) return done(valid.error());
  const auto save = [this, id, overwrite, attach = std::move(attach)](
                        const SheetRunner& runner, const std::string& name) -> Result<SavedStateStatus> {
    KERF_TRY(states_.check(id, name, overwrite));
    KERF_TRY_ASSIGN(SavedRun run, runner.save_run());
    if (attach) run.attachment = attach();
    const auto state = make_state(name, runner.sheet(), std::move(run), clock_.unix_us());
    KERF_TRY(states_.add(id, state, overwrite));
    return state->status;
  };
  on_strand(id, done, [save, name = std::move(state_id), done](SheetRunner& r) { done(save(r, name)); });
}

void Host::restore_state(const std::string& id, const std::string& state_id,
                         std::function<void(const std::string&)> restored, Callback<SheetStatus> done) {
  const std::shared_ptr<SheetRunner> runner = find(id);
  if (!runner) return done(missing(id));
  const Result<std::shared_ptr<const SavedState>> state = states_.find(id, state_id);
  if (!state.ok()) return done(state.error());
  // Held until the sheet is restored, because a loaded sheet takes memory.
  const auto place = std::make_shared<LoadPlace>(num_loads_);
  if (place->number > kMaxLoads) return done(too_many_restores());
  const auto load = [this, runner, state = *state, restored = std::move(restored), done, place]() -> Status {
    KERF_TRY_ASSIGN(sheet::Sheet loaded, load_sheet(*state));
    const auto sheet = std::make_shared<sheet::Sheet>(std::move(loaded));
    runner->post(
        [this, state, sheet, restored, done, place](SheetRunner& r) {
          if (Status s = r.continue_from(state->run, std::move(*sheet), ++num_made_); !s.ok()) return done(s.error());
          if (restored) restored(state->run.attachment);
          done(r.status());
        },
        [done](Error error) { done(std::move(error)); });
    return Nothing{};
  };
  const bool posted = builders_.make_strand().post([load, done] {
    if (const Status handed_on = catch_exceptions(load); !handed_on.ok()) done(handed_on.error());
  });
  if (!posted) done(host_stopping());
}

Result<sheet::Sheet> Host::load_sheet(const SavedState& state) {
  const std::int64_t bytes = bytes_to_build(*state.config, state.status.num_vertices);
  const PromisedBytes promised(promised_bytes_, bytes);
  if (!has_memory_for(promised.in_all())) return out_of_memory();
  const InterruptionScope scope([this] { return stopping_.load(); });
  Result<sheet::Sheet> loaded =
      catch_exceptions([&] { return sheet::Sheet::load(*state.config, *state.run.sheet, options_.make_integrator); });
  if (stopping_) return host_stopping();
  return loaded;
}

void Host::states(const std::string& id, const Callback<std::vector<SavedStateStatus>>& done) const {
  if (!find(id)) return done(missing(id));
  done(states_.list(id));
}

void Host::delete_state(const std::string& id, const std::string& state_id, const Callback<Nothing>& done) {
  if (!find(id)) return done(missing(id));
  done(states_.remove(id, state_id));
}

}  // namespace kerf::host
