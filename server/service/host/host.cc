#include "server/service/host/host.h"

#include <new>
#include <sstream>
#include <utility>

#include "server/base/catch_exceptions.h"
#include "server/base/memory_release.h"
#include "server/service/host/errors.h"
#include "server/service/host/host_strand.h"
#include "server/service/host/sheet_runner.h"
#include "server/service/host/step_group.h"

namespace kerf::host {

namespace {

Error no_sheet(const std::string& id) {
  return not_found("SHEET_NOT_FOUND", "there is no sheet \"" + id + "\"");
}

// False for a sheet that is being built or deleted.
bool is_served(const std::shared_ptr<SheetRunner>& runner) {
  return runner != nullptr && !runner->is_closing();
}

}  // namespace

Host::Host(HostOptions options, Clock& clock, Entropy& entropy)
    : options_(std::move(options)),
      clock_(clock),
      entropy_(entropy),
      vertices_(options_.max_total_vertices),
      states_(options_.max_states_per_sheet, options_.max_state_bytes),
      admission_(options_.max_load),
      workers_({.num_threads = options_.workers, .long_work = options_.long_work}),
      builders_({.long_work = options_.long_work, .max_taken_on = kMaxBuilders - 1, .is_background = true}) {
  if (options_.journal != nullptr) plan_to_mark();
}

Host::~Host() {
  stop();
}

void Host::create_sheet(std::string id, scene::SheetConfig config, bool paused, Callback<SheetStatus> done,
                        const std::stop_token& stop, RequestName<SheetStatus> request) {
  Creation made;
  made.paused = paused;
  made.done = std::move(done);
  made.stop = stop;
  made.request = std::move(request);
  create(std::move(id), std::move(config), std::move(made));
}

void Host::replay(std::string id, sheet::Recording recording, bool paused, Callback<SheetStatus> done,
                  const std::stop_token& stop) {
  if (const Status ordered = sheet::check_order(recording.entries); !ordered.ok()) return done(ordered.error());
  Creation made;
  made.playback = std::make_unique<Playback>(std::move(recording.entries), recording.torn_bytes);
  made.paused = paused;
  made.done = std::move(done);
  made.stop = stop;
  create(std::move(id), std::move(recording.config), std::move(made));
}

std::shared_ptr<SheetRunner> Host::find(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  const auto found = sheets_.find(id);
  return found != sheets_.end() && is_served(found->second) ? found->second : nullptr;
}

Error Host::missing(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  return stopping_ ? host_stopping() : no_sheet(id);
}

void Host::recording(const std::string& id, Callback<KeptRun> done) {
  on_strand(id, done, [done](SheetRunner& r) { r.answer<KeptRun>(done, r.kept_run()); });
}

void Host::delete_sheet(const std::string& id, Callback<Nothing> done, std::function<void()> closed) {
  std::shared_ptr<SheetRunner> runner;
  {
    const std::lock_guard lock(mutex_);
    const auto found = sheets_.find(id);
    if (found != sheets_.end() && is_served(found->second)) runner = found->second;
    if (runner) runner->announce_close();  // find() does not return it from here on.
  }
  if (!runner) return done(missing(id));
  runner->post(
      [this, id, done, closed = std::move(closed)](SheetRunner& r) {
        r.remove_from_journal([this, &r, id, done, closed](const Status& removed) {
          if (!removed.ok()) return done(removed.error());
          r.close(sheet::SinkEnd::kSheetDeleted);
          const Status ended = catch_exceptions([&]() -> Status {
            if (closed) closed();
            return Nothing{};
          });
          release(id);
          done(ended);
        });
      },
      done);
}

void Host::release(const std::string& id) {
  states_.forget(id);
  {
    const std::lock_guard lock(mutex_);
    sheets_.erase(id);
    shares_.erase(id);
  }
  try {
    plan_to_release_memory();
  } catch (const std::bad_alloc&) {  // The next sheet that ends tries again.
  }
}

void Host::plan_to_release_memory() {
  const auto give_back = [this, strand = workers_.make_strand()] {
    strand.post([this] {
      {
        const std::lock_guard lock(mutex_);
        release_timer_.reset();
      }
      release_free_memory();
    });
  };
  const std::lock_guard lock(mutex_);
  if (stopping_ || release_timer_) return;
  release_timer_ = clock_.schedule(clock_.now() + kReleaseDelay, give_back);
}

std::vector<std::string> Host::list() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> ids;
  for (const auto& [id, runner] : sheets_) {
    if (is_served(runner)) ids.push_back(id);
  }
  return ids;
}

void Host::status(const std::string& id, Callback<SheetStatus> done) {
  const std::shared_ptr<SheetRunner> runner = find(id);
  if (!runner) return done(missing(id));
  const std::shared_ptr<const SheetStatus> last = runner->last_status();
  if (last && runner->is_at_long_tick()) return done(*last);
  runner->post([done](SheetRunner& r) { r.answer<SheetStatus>(done, r.status()); },
               [done](Error error) { done(std::move(error)); });
}

std::vector<SheetStatus> Host::statuses(const std::vector<std::string>& ids) const {
  std::vector<SheetStatus> found;
  for (const std::string& id : ids) {
    const std::shared_ptr<SheetRunner> runner = find(id);
    if (!runner) continue;
    // A sheet without one is not durable yet.
    if (const std::shared_ptr<const SheetStatus> status = runner->last_status()) found.push_back(*status);
  }
  return found;
}

void Host::submit(const std::string& id, scene::Command command, Callback<CommandResult> done,
                  RequestName<CommandResult> request, bool is_of_stream) {
  const std::shared_ptr<SheetRunner> runner = find(id);
  const Status accepted =
      runner ? runner->enqueue(std::move(command), done, std::move(request), is_of_stream) : Status(missing(id));
  if (accepted.ok()) return;
  board_.update([](HostMetrics& m) { ++m.commands_refused; });
  done(accepted.error());
}

void Host::schedule(const std::string& id, scene::Command command, std::int64_t at_tick, Callback<std::int64_t> done,
                    RequestName<std::int64_t> request) {
  const auto answer = [this, done = std::move(done)](Result<std::int64_t> number) {
    if (!number.ok()) board_.update([](HostMetrics& m) { ++m.commands_refused; });
    done(std::move(number));
  };
  on_strand<std::int64_t>(
      id, answer,
      [command = std::move(command), at_tick, answer, request = std::move(request)](SheetRunner& r) mutable {
        r.answer<std::int64_t>(answer, r.schedule(std::move(command), at_tick, request));
      });
}

void Host::scheduled(const std::string& id, Callback<std::vector<ScheduledCommand>> done) {
  on_strand(id, done, [done](SheetRunner& r) { r.answer<std::vector<ScheduledCommand>>(done, r.scheduled()); });
}

void Host::cancel(const std::string& id, std::int64_t number, Callback<ScheduledCommand> done,
                  RequestName<ScheduledCommand> request) {
  on_strand(id, done, [number, done, request = std::move(request)](SheetRunner& r) {
    r.answer<ScheduledCommand>(done, r.cancel(number, request));
  });
}

void Host::set_attachments(Attachments attachments) {
  attachments_.set(std::move(attachments));
}

void Host::set_command_listener(CommandListener listener) {
  listener_.set(std::move(listener));
}

void Host::release_grab(const std::string& id, std::string grab_id) {
  if (const std::shared_ptr<SheetRunner> runner = find(id)) runner->release_grab(std::move(grab_id));
}

void Host::pause(const std::string& id, Callback<SheetStatus> done) {
  const std::shared_ptr<SheetRunner> runner = find(id);
  if (!runner) return done(missing(id));
  runner->post_pause(done);
}

void Host::resume(const std::string& id, Callback<SheetStatus> done) {
  on_strand(id, done, [this, id, done](SheetRunner& r) {
    if (Status s = check_run(id, r, r.speed()); !s.ok()) return r.answer<SheetStatus>(done, s.error());
    if (Status s = r.resume(); !s.ok()) return r.answer<SheetStatus>(done, s.error());
    r.answer<SheetStatus>(done, r.status());
  });
}

void Host::set_speed(const std::string& id, double speed, Callback<SheetStatus> done) {
  if (!(speed >= kMinSpeed && speed <= kMaxSpeed)) {
    std::ostringstream message;
    message << "speed is " << speed << "; must be in " << kMinSpeed << ".." << kMaxSpeed << ", and 1 is live";
    return done(invalid_argument("OUT_OF_RANGE", message.str(), "speed"));
  }
  on_strand(id, done, [this, id, speed, done](SheetRunner& r) {
    if (!r.is_paused()) {
      if (Status s = check_run(id, r, speed); !s.ok()) return r.answer<SheetStatus>(done, s.error());
    }
    r.set_speed(speed);
    r.answer<SheetStatus>(done, r.status());
  });
}

Status Host::check_ticks(std::int64_t ticks) const {
  const std::int32_t limit = options_.max_step_ticks;
  if (ticks >= 1 && ticks <= limit) return Nothing{};
  return invalid_argument("OUT_OF_RANGE",
                          "ticks is " + std::to_string(ticks) + "; must be 1 to " + std::to_string(limit), "ticks");
}

void Host::step(const std::string& id, std::int64_t ticks, Callback<SheetStatus> done, std::stop_token stop) {
  if (const Status valid = check_ticks(ticks); !valid.ok()) return done(valid.error());
  on_strand(id, done, [ticks, done, stop = std::move(stop)](SheetRunner& r) { r.step(ticks, done, stop); });
}

void Host::step_all(const std::vector<std::string>& ids, std::int64_t ticks, std::shared_ptr<StepVisitor> visitor,
                    Callback<Nothing> done, std::stop_token stop) {
  if (const Status valid = check_ticks(ticks); !valid.ok()) return done(valid.error());
  std::vector<std::shared_ptr<SheetRunner>> runners;
  for (const std::string& id : ids) {
    runners.push_back(find(id));
    if (runners.back()) continue;
    Error error = missing(id);
    if (error.code == ErrorCode::kNotFound) error.field = "names[" + std::to_string(runners.size() - 1) + "]";
    return done(std::move(error));
  }
  std::make_shared<StepGroup>(std::move(runners), ticks, std::move(visitor), std::move(done), std::move(stop))->begin();
}

void Host::inspect(const std::string& id, std::function<void(const sheet::Sheet&)> look, Callback<Nothing> done) {
  on_strand(id, done, [look = std::move(look), done](SheetRunner& r) {
    look(r.sheet());
    r.answer<Nothing>(done, Nothing{});
  });
}

void Host::add_sink(const std::string& id, std::shared_ptr<sheet::SnapshotSink> sink, Callback<Nothing> done) {
  on_strand(id, done, [sink = std::move(sink), done](SheetRunner& r) {
    r.add_sink(sink);
    done(Nothing{});
  });
}

void Host::refresh_sink(const std::string& id, std::shared_ptr<sheet::SnapshotSink> sink, Callback<Nothing> done) {
  on_strand(id, done, [sink = std::move(sink), done](SheetRunner& r) {
    r.refresh_sink(sink);
    done(Nothing{});
  });
}

void Host::remove_sink(const std::string& id, std::shared_ptr<sheet::SnapshotSink> sink, Callback<Nothing> done) {
  on_strand(id, done, [sink = std::move(sink), done](SheetRunner& r) {
    r.remove_sink(sink);
    done(Nothing{});
  });
}

HostMetrics Host::metrics() const {
  return board_.read();
}

double Host::load() const {
  return static_cast<double>(board_.worker_need()) / (static_cast<double>(WorkerNeed::kWhole) * options_.workers);
}

const HostOptions& Host::options() const {
  return options_;
}

TenantUse Host::tenant_use(const std::string& tenant) const {
  const std::lock_guard lock(mutex_);
  return use_of(tenant);
}

TenantUse Host::use_of(const std::string& tenant) const {
  const std::string prefix = tenant + "-";
  TenantUse use;
  std::int64_t need = 0;
  for (auto at = shares_.lower_bound(prefix); at != shares_.end() && at->first.starts_with(prefix); ++at) {
    const std::shared_ptr<const SheetShare> share = at->second.lock();
    if (!share) continue;
    ++use.sheets;
    use.vertices += share->vertices();
    need += share->need();
  }
  use.workers = in_workers(need);
  use.state_bytes = states_.bytes_of(tenant);
  return use;
}

std::optional<Host::NamedTenant> Host::find_tenant(const std::string& id) const {
  std::string name = options_.find_tenant ? tenant_of(id) : std::string();
  if (name.empty()) return std::nullopt;
  const std::optional<TenantLimits> limits = options_.find_tenant(name);
  return limits ? std::optional(NamedTenant{std::move(name), *limits}) : std::nullopt;
}

Status Host::check_run(const std::string& id, SheetRunner& runner, double speed) {
  const std::optional<NamedTenant> tenant = find_tenant(id);
  if (!tenant) return Nothing{};
  const std::int64_t need = runner.need_at(speed);
  const std::lock_guard lock(mutex_);
  KERF_TRY(check_need(tenant->name, tenant->limits, use_of(tenant->name), in_workers(need - runner.share().need())));
  runner.share().set_need(need);
  return Nothing{};
}

std::string Host::turns_of(const std::string& id) const {
  const std::optional<NamedTenant> tenant = find_tenant(id);
  return tenant ? tenant->name : std::string();
}

SharedSlip& Host::slip_of(const std::string& id) {
  const std::string tenant = turns_of(id);
  if (tenant.empty()) return slip_;
  const std::lock_guard lock(mutex_);
  return tenant_slips_[tenant];
}

// Waits for the builders first, because they post to the workers.
void Host::wait_idle() {
  builders_.wait_idle();
  workers_.wait_idle();
}

void Host::stop() {
  Runners taken;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    if (release_timer_) clock_.cancel(*release_timer_);
    if (mark_timer_) clock_.cancel(*mark_timer_);
    taken.swap(sheets_);
  }
  if (options_.journal != nullptr) {  // Answers to changes that become durable in time still leave.
    for (const auto& [id, runner] : taken) {
      if (runner) runner->post([](SheetRunner& r) { r.save_if_due(); }, [](const Error&) {});
    }
    workers_.wait_idle();
    mark(taken);
    options_.journal->flush(kFlushLimit);
  }
  for (auto& [id, runner] : taken) {
    if (!runner) continue;  // admit() will refuse it.
    SheetRunner* const sheet = runner.get();
    // Moves the last reference too, so that the workers destroy sheets in parallel.
    sheet->post([held = std::move(runner)](SheetRunner& r) { r.close(sheet::SinkEnd::kHostStopping); },
                [](const Error&) {});
  }
  workers_.wait_idle();
  has_closed_sheets_ = true;
  builders_.join();  // First, because they post to the workers.
  workers_.join();
}

bool Host::has_closed_sheets() const {
  return has_closed_sheets_;
}

}  // namespace kerf::host
