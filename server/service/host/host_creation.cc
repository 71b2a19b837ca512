#include <algorithm>
#include <cmath>
#include <utility>

#include "server/base/catch_exceptions.h"
#include "server/base/interruption.h"
#include "server/base/memory_headroom.h"
#include "server/base/overloaded.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/service/host/errors.h"
#include "server/service/host/host.h"
#include "server/service/host/promised_bytes.h"
#include "server/service/host/sheet_runner.h"

// Makes the sheets of a Host: reserves, builds and begins them.
namespace kerf::host {

namespace {

// Number of polls of the interruption per look at the free memory, which costs more than the other checks.
constexpr int kPollsToALook = 32;

Error too_many_vertices(std::int64_t count, std::int32_t limit) {
  return resource_exhausted("TOO_MANY_VERTICES", "the sheet has " + std::to_string(count) +
                                                     " vertices; this server's limit is " + std::to_string(limit));
}

// Returns the number of vertices of a mesh if it is known without building; else 0.
std::int64_t declared_vertices(const scene::MeshSource& mesh) {
  using Count = std::int64_t;
  return std::visit(Overloaded{
                        [](const scene::GridSource& grid) { return Count{grid.columns} * grid.rows; },
                        [](const scene::ObjSource& /*text*/) { return Count{0}; },
                        [](const scene::PlySource& /*bytes*/) { return Count{0}; },
                        [](const scene::ArraySource& arrays) { return Count{arrays.num_vertices()}; },
                        [](const scene::OutlineSource& /*outline*/) { return Count{0}; },
                    },
                    mesh);
}

// Returns the number of vertices of a config, as far as it is known without building.
std::int64_t declared_vertices(const scene::SheetConfig& config) {
  if (config.components.empty()) return declared_vertices(config.mesh);
  std::int64_t sum = 0;
  for (const scene::Component& component : config.components) sum += declared_vertices(component.mesh);
  return sum;
}

// Returns the expected need of a sheet that runs; nothing if its config will be refused.
std::optional<std::int64_t> guessed_need(const scene::SheetConfig& config) {
  if (!(config.tick_rate_hz > 0.0)) return std::nullopt;
  const Nanoseconds period(std::llround(1.0e9 / config.tick_rate_hz));
  return WorkerNeed(period, WorkerNeed::guessed_tick(declared_vertices(config))).value();
}

std::string random_id(std::uint64_t bits) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string id = "sheet-";
  for (int i = 0; i < 10; ++i, bits >>= 4U) id += kDigits[bits & 15U];
  return id;
}

}  // namespace

void Host::create(std::string id, scene::SheetConfig config, Creation made) {
  if (id.empty()) id = config.sheet_id;
  if (id.empty()) id = random_id(entropy_.next());
  // Shared, because posted functions must be copyable. Made first: from here on every failure is answered.
  const auto creation = std::make_shared<Creation>(std::move(made));
  const bool paused = creation->paused;
  const Status queued = catch_exceptions([&]() -> Status {
    Result<std::shared_ptr<SheetShare>> reserved = reserve(id, config, *creation);
    KERF_TRY(reserved);
    creation->share = std::move(reserved).value();
    creation->id = std::move(id);
    const std::optional<std::int64_t> need = paused ? std::nullopt : guessed_need(config);
    if (need) creation->need = std::make_shared<ExpectedNeed>(board_, *need);
    const auto shared = std::make_shared<scene::SheetConfig>(std::move(config));
    const bool posted = builders_.make_strand(turns_of(creation->id)).post([this, creation, shared] {
      const Status handed_on = catch_exceptions([&] { return build_and_hand_on(creation, std::move(*shared)); });
      if (!handed_on.ok()) refuse(*creation, handed_on.error());
    });
    return posted ? Status(Nothing{}) : Status(host_stopping());
  });
  if (!queued.ok()) refuse(*creation, queued.error());
}

Status Host::build_and_hand_on(const std::shared_ptr<Creation>& creation, scene::SheetConfig config) {
  KERF_TRY_ASSIGN(sheet::Sheet built, build(std::move(config), *creation));
  const auto sheet = std::make_shared<sheet::Sheet>(std::move(built));
  const Workers::Strand strand = workers_.make_strand(turns_of(creation->id));
  const bool posted = strand.post([this, creation, sheet, strand] {
    if (const Status begun = begin(*creation, std::move(*sheet), strand); !begun.ok()) {
      refuse(*creation, begun.error());
    }
  });
  return posted ? Status(Nothing{}) : Status(host_stopping());
}

// Runs on the sheet's strand, before any work that find() could post to it.
Status Host::begin(Creation& creation, sheet::Sheet sheet, const Workers::Strand& strand) {
  const auto runner = std::make_shared<SheetRunner>(
      creation.id, std::move(sheet),
      SheetRunner::Context{options_, clock_, board_, listener_, attachments_, slip_of(creation.id), unsaved_, stopping_,
                           [this](const std::string& id) { release(id); }, ++num_made_},
      strand, creation.share);
  const Status begun = catch_exceptions([&]() -> Status {
    if (stopping_) return host_stopping();
    const bool is_new = creation.stored == nullptr;
    if (options_.journal != nullptr && is_new) {
      runner->keep_in(*options_.journal, options_.journal->new_sheet_number(), SheetJournal::kNotStored);
    }
    runner->begin(creation.paused, options_.make_recording ? options_.make_recording(creation.id) : nullptr,
                  std::move(creation.playback));
    std::optional<std::int64_t> differs_at;
    if (!is_new) {
      KERF_TRY_ASSIGN(differs_at, runner->recover(*creation.stored));
    }
    if (!admit(creation.id, runner)) return host_stopping();
    creation.need.reset();
    SheetStatus status = runner->status();
    if (!is_new) {
      KERF_TRY(keep_named(*creation.stored, runner->sheet().shared_config()));
      const bool is_changed = runner->is_changed() || !creation.stored->named.empty();
      creation.recovered(RecoveredSheet{std::move(status), is_changed, differs_at});
      return Nothing{};
    }
    runner->store_creation(creation.request, status);
    runner->answer<SheetStatus>(creation.done, std::move(status));
    return Nothing{};
  });
  if (!begun.ok()) runner->close(stopping_ ? sheet::SinkEnd::kHostStopping : sheet::SinkEnd::kSheetLost);
  return begun;
}

void Host::refuse(Creation& creation, const Error& error) {
  creation.need.reset();
  if (creation.share) {  // Frees the name and the vertices before the answer, so that a retry finds them free.
    creation.share->give_back();
    release(creation.id);
  }
  if (creation.recovered) return creation.recovered(error);
  creation.done(error);
}

Status Host::settle(const Creation& creation, const sheet::Sheet& built) {
  const std::int64_t vertices = built.mesh().num_vertices();
  const std::optional<NamedTenant> tenant = creation.stored ? std::nullopt : find_tenant(creation.id);
  const std::lock_guard lock(mutex_);
  if (tenant) {
    const TenantUse use = use_of(tenant->name);
    KERF_TRY(check_vertices(tenant->name, tenant->limits, use.vertices + vertices - creation.share->vertices()));
    if (creation.need) {  // A mesh that declared no size was expected to need nothing.
      const Nanoseconds period(std::llround(1.0e9 * built.dt()));
      const std::int64_t need = WorkerNeed(period, WorkerNeed::guessed_tick(vertices)).value();
      KERF_TRY(check_need(tenant->name, tenant->limits, use, in_workers(need - creation.share->need())));
      creation.share->set_need(need);
    }
  }
  return creation.share->settle(vertices);
}

Result<std::shared_ptr<SheetShare>> Host::reserve(const std::string& id, const scene::SheetConfig& config,
                                                  const Creation& creation) {
  if (!scene::is_valid_sheet_id(id)) {
    return invalid_argument("SHEET_ID", "sheet_id must match [a-z][a-z0-9-]{0,62}", "sheet_id");
  }
  const std::int64_t declared = declared_vertices(config);
  if (declared > options_.max_vertices_per_sheet && declared <= scene::kMaxVertices) {
    return too_many_vertices(declared, options_.max_vertices_per_sheet);
  }
  const std::lock_guard lock(mutex_);
  if (stopping_) return host_stopping();
  if (sheets_.contains(id)) {
    return already_exists("SHEET_EXISTS", "a sheet \"" + id + "\" already exists", "sheet_id");
  }
  if (sheets_.size() >= static_cast<std::size_t>(options_.max_sheets)) {
    return resource_exhausted("TOO_MANY_SHEETS", "this server's limit of " + std::to_string(options_.max_sheets) +
                                                     " sheets is reached; delete one");
  }
  // Reserves nothing for a size beyond any sheet's limit, which is refused later. A mesh of unknown size reserves one
  // vertex, so that it is refused before the build if none is left.
  const std::int64_t taken = declared <= scene::kMaxVertices ? std::max<std::int64_t>(declared, 1) : 0;
  const std::int64_t need = creation.paused ? 0 : guessed_need(config).value_or(0);
  if (const std::optional<NamedTenant> tenant = find_tenant(id); tenant && !creation.stored) {
    KERF_TRY(check_new_sheet(tenant->name, tenant->limits, use_of(tenant->name), taken, in_workers(need)));
  }
  KERF_TRY(vertices_.take(taken));
  auto share = std::make_shared<SheetShare>(vertices_, taken, need);
  if (!creation.paused) {
    if (Status s = admission_.admit(load(), options_.workers); !s.ok()) {
      board_.update([](HostMetrics& m) { ++m.overload_refusals; });
      return s.error();
    }
  }
  sheets_.emplace(id, nullptr);
  shares_[id] = share;
  return share;
}

Result<sheet::Sheet> Host::build(scene::SheetConfig config, const Creation& creation) {
  // Stored in the config and so in a recording: a cut refused here is refused in a replay too.
  config.max_vertices = std::min(config.max_vertices, options_.max_vertices_per_sheet);
  const std::optional<NamedTenant> tenant = creation.stored ? std::nullopt : find_tenant(creation.id);
  if (tenant && tenant->limits.max_vertices > 0) {
    const std::int64_t most = std::max<std::int64_t>(tenant->limits.max_vertices, 3);
    config.max_vertices = static_cast<std::int32_t>(std::min<std::int64_t>(config.max_vertices, most));
  }
  const std::int64_t declared = declared_vertices(config);
  const std::int64_t bytes = declared <= scene::kMaxVertices ? bytes_to_build(config, declared) : 0;
  Status wanted = check_wanted(creation);
  KERF_TRY(wanted);
  const PromisedBytes promised(promised_bytes_, bytes);
  if (!has_memory_for(promised.in_all())) return out_of_memory();
  const InterruptionScope scope([&, polls = 0]() mutable {
    wanted = check_wanted(creation);
    const bool looks = polls++ % kPollsToALook == 0;
    if (wanted.ok() && looks && !has_memory_for(0)) wanted = out_of_memory();
    return !wanted.ok();
  });
  Result<sheet::Sheet> built = catch_exceptions([&]() -> Result<sheet::Sheet> {
    const bool is_saved = creation.stored && creation.stored->state;
    if (!is_saved) return sheet::Sheet::create(std::move(config), options_.make_integrator);
    return sheet::Sheet::load(std::move(config), *creation.stored->state->run.sheet, options_.make_integrator);
  });
  KERF_TRY(wanted);
  KERF_TRY(built);
  KERF_TRY(settle(creation, *built));
  if (!has_memory_for(0)) return out_of_memory();
  KERF_TRY(check_wanted(creation));
  return built;
}

Status Host::check_wanted(const Creation& creation) const {
  if (stopping_) return host_stopping();
  if (creation.stop.stop_requested()) {
    return aborted("CREATION_ABANDONED", "the client left before its sheet was built; request it again");
  }
  return Nothing{};
}

bool Host::admit(const std::string& id, const std::shared_ptr<SheetRunner>& runner) {
  const std::lock_guard lock(mutex_);
  if (stopping_) return false;
  sheets_[id] = runner;
  return true;
}

}  // namespace kerf::host
