#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

#include "server/base/catch_exceptions.h"
#include "server/base/interruption.h"
#include "server/base/memory_headroom.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/service/host/errors.h"
#include "server/service/host/host.h"
#include "server/service/host/host_strand.h"
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

}  // namespace

void Host::save_state(const std::string& id, std::string state_id, bool overwrite, Callback<SavedStateStatus> done) {
  if (const Status valid = check_state_id(state_id); !valid.ok()) return done(valid.error());
  const auto save = [this, id, overwrite, name = std::move(state_id), done](SheetRunner& runner) -> Status {
    KERF_TRY(states_.check(id, name, overwrite));
    KERF_TRY_ASSIGN(SavedState saved, runner.save_state(name));
    const auto state = std::make_shared<const SavedState>(std::move(saved));
    if (const std::optional<NamedTenant> tenant = find_tenant(id)) {
      KERF_TRY(states_.add(id, state, overwrite, tenant->name, [&tenant](std::int64_t bytes) {
        return check_state_bytes(tenant->name, tenant->limits, bytes);
      }));
    } else {
      KERF_TRY(states_.add(id, state, overwrite));
    }
    runner.store_named(state, done);
    return Nothing{};
  };
  on_strand(id, done, [save, done](SheetRunner& r) {
    r.when_settled([save, done, &r](const Status& settled) {
      if (!settled.ok()) return done(settled.error());
      if (const Status s = save(r); !s.ok()) done(s.error());
    });
  });
}

void Host::restore_state(const std::string& id, const std::string& state_id, Callback<SheetStatus> done,
                         RequestName<SheetStatus> request) {
  const std::shared_ptr<SheetRunner> runner = find(id);
  if (!runner) return done(missing(id));
  const Result<std::shared_ptr<const SavedState>> state = states_.find(id, state_id);
  if (!state.ok()) return done(state.error());
  // Held until the sheet is restored, because a loaded sheet takes memory.
  const auto place = std::make_shared<LoadPlace>(num_loads_);
  if (place->number > kMaxLoads) return done(too_many_restores());
  const auto load = [this, runner, state = *state, done, place, request = std::move(request)]() -> Status {
    KERF_TRY_ASSIGN(sheet::Sheet loaded, load_sheet(*state));
    const auto sheet = std::make_shared<sheet::Sheet>(std::move(loaded));
    runner->post(
        [this, state, sheet, done, place, request](SheetRunner& r) {
          const Status s = r.continue_from(state->run, std::move(*sheet), ++num_made_, request);
          if (!s.ok()) return done(s.error());
          r.answer<SheetStatus>(done, r.status());
        },
        [done](Error error) { done(std::move(error)); });
    return Nothing{};
  };
  const bool posted = builders_.make_strand(turns_of(id)).post([load, done] {
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

void Host::states(const std::string& id, Callback<std::vector<SavedStateStatus>> done) {
  on_strand(id, done, [this, id, done](SheetRunner& r) { r.answer_states(states_.list(id), done); });
}

void Host::delete_state(const std::string& id, const std::string& state_id, Callback<Nothing> done) {
  on_strand(id, done, [this, id, state_id, done](SheetRunner& r) {
    if (const Status removed = states_.remove(id, state_id); !removed.ok()) return done(removed.error());
    r.remove_named(state_id, done);
  });
}

}  // namespace kerf::host
