#include "server/host/host.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <mutex>
#include <sstream>
#include <utility>

#include "server/host/admission.h"
#include "server/host/metrics_board.h"
#include "server/host/sheet_runner.h"
#include "server/host/workers.h"

namespace kerf::host {

namespace {

Error not_found(const std::string& id) {
  return {ErrorCode::kNotFound, "SHEET_NOT_FOUND", "there is no sheet \"" + id + "\"", ""};
}

Error stopping() {
  return {ErrorCode::kUnavailable, "HOST_STOPPING", "the server is stopping", ""};
}

Error too_many_vertices(std::int64_t count, std::int32_t limit) {
  return {ErrorCode::kResourceExhausted, "TOO_MANY_VERTICES",
          "the sheet has " + std::to_string(count) + " vertices; this server's limit is " + std::to_string(limit), ""};
}

// Vertices that a config asks for, as far as that can be told without building it.
std::int64_t declared_vertices(const sheet::SheetConfig& config) {
  if (const auto* grid = std::get_if<sheet::GridSource>(&config.mesh)) return std::int64_t{grid->columns} * grid->rows;
  if (const auto* arrays = std::get_if<sheet::ArraySource>(&config.mesh)) return arrays->num_vertices();
  return 0;
}

std::string random_id(std::uint64_t bits) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string id = "sheet-";
  for (int i = 0; i < 10; ++i, bits >>= 4U) id += kDigits[bits & 15U];
  return id;
}

}  // namespace

class Host::Impl {
 public:
  Impl(HostOptions options, Clock& clock, Entropy& entropy)
      : options_(std::move(options)),
        clock_(clock),
        entropy_(entropy),
        admission_(options_.max_load),
        workers_(options_.workers) {}

  // `entries`: of a recording that the sheet is to play.
  void create_sheet(std::string id, sheet::SheetConfig config, std::optional<std::vector<sheet::RecordedTick>> entries,
                    bool paused, Callback<SheetStatus> done) {
    if (id.empty()) id = config.sheet_id;
    if (id.empty()) id = random_id(entropy_.next());
    if (Status s = reserve(id, config, paused); !s) return done(s.error());
    const Workers::Strand strand = workers_.make_strand();
    const std::shared_ptr<ExpectedNeed> expected = paused ? nullptr : expected_need(config);
    auto shared = std::make_shared<sheet::SheetConfig>(std::move(config));
    // Shared, as what is posted must be copyable.
    const auto playback = std::make_shared<std::unique_ptr<Playback>>(
        entries ? std::make_unique<Playback>(std::move(*entries)) : nullptr);
    const bool posted = strand.post([this, id, shared, playback, paused, strand, done, expected] {
      Result<sheet::Sheet> built = stopping_ ? stopping() : build(std::move(*shared));
      if (!built) {
        release(id);
        return done(built.error());
      }
      const auto runner = std::make_shared<SheetRunner>(id, std::move(built).value(), context(), strand);
      // Begun before it can be found: on this strand, ahead of whatever finds it.
      runner->begin(paused, options_.make_recording ? options_.make_recording(id) : nullptr, std::move(*playback));
      if (!admit(id, runner)) {
        runner->close(sheet::SinkEnd::kHostStopping);
        return done(stopping());
      }
      done(runner->status());
    });
    if (!posted) done(stopping());
  }

  void delete_sheet(const std::string& id, Callback<Nothing> done, std::function<void()> closed) {
    std::shared_ptr<SheetRunner> runner;
    {
      const std::lock_guard lock(mutex_);
      const auto found = sheets_.find(id);
      if (found != sheets_.end()) runner = std::move(found->second);  // nobody finds it from here on
    }
    if (!runner) return done(missing(id));
    runner->post(
        [this, id, done, closed = std::move(closed)](SheetRunner& r) {
          r.close(sheet::SinkEnd::kSheetDeleted);
          if (closed) closed();
          release(id);
          done(Nothing{});
        },
        done);
  }

  [[nodiscard]] std::vector<std::string> list() const {
    const std::lock_guard lock(mutex_);
    std::vector<std::string> ids;
    for (const auto& [id, runner] : sheets_) {
      if (runner) ids.push_back(id);
    }
    return ids;
  }

  [[nodiscard]] std::vector<SheetStatus> statuses(const std::vector<std::string>& ids) const;
  void submit(const std::string& id, sheet::Command command, Callback<CommandResult> done);
  void schedule(const std::string& id, sheet::Command command, std::int64_t at_tick,
                const Callback<std::int64_t>& done);

  void release_grab(const std::string& id, std::string grab_id) {
    if (const std::shared_ptr<SheetRunner> runner = find(id)) runner->release_grab(std::move(grab_id));
  }

  // Runs `work` on the sheet's strand; what stands against it goes to `done`.
  template <typename T>
  void on_strand(const std::string& id, const Callback<T>& done, std::function<void(SheetRunner&)> work) {
    const std::shared_ptr<SheetRunner> runner = find(id);
    if (!runner) return done(missing(id));
    runner->post(std::move(work), [done](Error error) { done(std::move(error)); });
  }

  void set_command_listener(CommandListener listener) { listener_.set(std::move(listener)); }
  [[nodiscard]] HostMetrics metrics() const { return board_.read(); }
  [[nodiscard]] double load() const {
    return static_cast<double>(board_.worker_need()) / (static_cast<double>(WorkerNeed::kWhole) * options_.workers);
  }
  [[nodiscard]] const HostOptions& options() const { return options_; }
  void wait_idle() { workers_.wait_idle(); }

  void stop() {
    std::map<std::string, std::shared_ptr<SheetRunner>> taken;
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
      taken.swap(sheets_);
    }
    for (auto& [id, runner] : taken) {
      if (!runner) continue;  // admit() will turn it away, or its deletion is on its way
      runner->post([](SheetRunner& r) { r.close(sheet::SinkEnd::kHostStopping); }, [](const Error&) {});
      runner.reset();  // the workers take sheets down side by side
    }
    workers_.join();
  }

 private:
  SheetRunner::Context context() { return {options_, clock_, board_, listener_, stopping_, ++num_made_}; }

  std::shared_ptr<ExpectedNeed> expected_need(const sheet::SheetConfig& config) {
    if (!(config.tick_rate_hz > 0.0)) return nullptr;  // will be refused
    const Nanoseconds period(std::llround(1.0e9 / config.tick_rate_hz));
    return std::make_shared<ExpectedNeed>(board_, WorkerNeed(period, declared_vertices(config)).value());
  }

  Status reserve(const std::string& id, const sheet::SheetConfig& config, bool paused) {
    if (!sheet::is_valid_sheet_id(id)) {
      return invalid_argument("SHEET_ID", "sheet_id must match [a-z][a-z0-9-]{0,62}", "sheet_id");
    }
    const std::int64_t declared = declared_vertices(config);
    if (declared > options_.max_vertices_per_sheet && declared <= sheet::kMaxVertices) {
      return too_many_vertices(declared, options_.max_vertices_per_sheet);
    }
    const std::lock_guard lock(mutex_);
    if (stopping_) return stopping();
    if (sheets_.contains(id)) {
      return Error{ErrorCode::kAlreadyExists, "SHEET_EXISTS", "there is a sheet \"" + id + "\" already", "sheet_id"};
    }
    if (sheets_.size() >= static_cast<std::size_t>(options_.max_sheets)) {
      return Error{ErrorCode::kResourceExhausted, "TOO_MANY_SHEETS",
                   "this server's limit of " + std::to_string(options_.max_sheets) + " sheets is reached; delete one",
                   ""};
    }
    if (!paused) {
      if (Status s = admission_.admit(load(), options_.workers); !s) {
        board_.update([](HostMetrics& m) { ++m.overload_refusals; });
        return s;
      }
    }
    sheets_.emplace(id, nullptr);
    return Nothing{};
  }

  Result<sheet::Sheet> build(sheet::SheetConfig config) {
    // In the config, and so in a recording: a cut that is refused here is refused in a replay.
    config.max_vertices = std::min(config.max_vertices, options_.max_vertices_per_sheet);
    return sheet::Sheet::create(std::move(config), options_.make_integrator);
  }

  void release(const std::string& id) {
    const std::lock_guard lock(mutex_);
    sheets_.erase(id);
  }

  bool admit(const std::string& id, const std::shared_ptr<SheetRunner>& runner) {
    const std::lock_guard lock(mutex_);
    if (stopping_) return false;
    sheets_[id] = runner;
    return true;
  }

  [[nodiscard]] std::shared_ptr<SheetRunner> find(const std::string& id) const {
    const std::lock_guard lock(mutex_);
    const auto found = sheets_.find(id);
    return found == sheets_.end() ? nullptr : found->second;
  }

  [[nodiscard]] Error missing(const std::string& id) const {
    const std::lock_guard lock(mutex_);
    return stopping_ ? stopping() : not_found(id);
  }

  const HostOptions options_;
  Clock& clock_;
  Entropy& entropy_;
  MetricsBoard board_;
  ListenerSlot listener_;
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<SheetRunner>> sheets_;  // null: being built or deleted. Guarded by mutex_
  std::atomic<std::uint64_t> num_made_{0};
  std::atomic<bool> stopping_{false};  // set under mutex_
  Admission admission_;                // guarded by mutex_
  Workers workers_;                    // last: its threads use everything above
};

std::vector<SheetStatus> Host::Impl::statuses(const std::vector<std::string>& ids) const {
  std::vector<SheetStatus> found;
  for (const std::string& id : ids) {
    if (const std::shared_ptr<SheetRunner> runner = find(id)) found.push_back(*runner->last_status());
  }
  return found;
}

void Host::Impl::submit(const std::string& id, sheet::Command command, Callback<CommandResult> done) {
  const std::shared_ptr<SheetRunner> runner = find(id);
  Status accepted = Nothing{};
  if (!runner) {
    accepted = missing(id);
  } else if (accepted = sheet::validate(command); accepted) {
    accepted = runner->enqueue(std::move(command), done);
  }
  if (accepted) return;
  board_.update([](HostMetrics& m) { ++m.commands_refused; });
  done(accepted.error());
}

void Host::Impl::schedule(const std::string& id, sheet::Command command, std::int64_t at_tick,
                          const Callback<std::int64_t>& done) {
  const auto answer = [this, done](Result<std::int64_t> number) {
    if (!number) board_.update([](HostMetrics& m) { ++m.commands_refused; });
    done(std::move(number));
  };
  if (const Status valid = sheet::validate(command); !valid) return answer(valid.error());
  on_strand<std::int64_t>(id, answer, [command = std::move(command), at_tick, answer](SheetRunner& r) mutable {
    answer(r.schedule(std::move(command), at_tick));
  });
}

Host::Host(HostOptions options, Clock& clock, Entropy& entropy)
    : impl_(std::make_unique<Impl>(std::move(options), clock, entropy)) {}

Host::~Host() {
  stop();
}

void Host::create_sheet(std::string id, sheet::SheetConfig config, bool paused, Callback<SheetStatus> done) {
  impl_->create_sheet(std::move(id), std::move(config), std::nullopt, paused, std::move(done));
}

void Host::replay(std::string id, sheet::Recording recording, bool paused, Callback<SheetStatus> done) {
  if (const Status ordered = sheet::check_order(recording.entries); !ordered) return done(ordered.error());
  impl_->create_sheet(std::move(id), std::move(recording.config), std::move(recording.entries), paused,
                      std::move(done));
}

void Host::recording(const std::string& id, Callback<KeptRun> done) {
  impl_->on_strand(id, done, [done](SheetRunner& r) { done(r.kept_run()); });
}

void Host::delete_sheet(const std::string& id, Callback<Nothing> done, std::function<void()> closed) {
  impl_->delete_sheet(id, std::move(done), std::move(closed));
}

std::vector<std::string> Host::list() const {
  return impl_->list();
}

void Host::status(const std::string& id, Callback<SheetStatus> done) {
  impl_->on_strand(id, done, [done](SheetRunner& r) { done(r.status()); });
}

std::vector<SheetStatus> Host::statuses(const std::vector<std::string>& ids) const {
  return impl_->statuses(ids);
}

void Host::submit(const std::string& id, sheet::Command command, Callback<CommandResult> done) {
  impl_->submit(id, std::move(command), std::move(done));
}

void Host::schedule(const std::string& id, sheet::Command command, std::int64_t at_tick, Callback<std::int64_t> done) {
  impl_->schedule(id, std::move(command), at_tick, done);
}

void Host::scheduled(const std::string& id, Callback<std::vector<WaitingCommand>> done) {
  impl_->on_strand(id, done, [done](SheetRunner& r) { done(r.scheduled()); });
}

void Host::cancel(const std::string& id, std::int64_t number, Callback<WaitingCommand> done) {
  impl_->on_strand(id, done, [number, done](SheetRunner& r) { done(r.cancel(number)); });
}

void Host::set_command_listener(CommandListener listener) {
  impl_->set_command_listener(std::move(listener));
}

void Host::release_grab(const std::string& id, std::string grab_id) {
  impl_->release_grab(id, std::move(grab_id));
}

void Host::pause(const std::string& id, Callback<SheetStatus> done) {
  impl_->on_strand(id, done, [done](SheetRunner& r) {
    r.pause();
    done(r.status());
  });
}

void Host::resume(const std::string& id, Callback<SheetStatus> done) {
  impl_->on_strand(id, done, [done](SheetRunner& r) {
    if (Status s = r.resume(); !s) return done(s.error());
    done(r.status());
  });
}

void Host::set_speed(const std::string& id, double speed, Callback<SheetStatus> done) {
  if (!(speed >= kMinSpeed && speed <= kMaxSpeed)) {
    std::ostringstream message;
    message << "speed is " << speed << "; must be in " << kMinSpeed << ".." << kMaxSpeed << ", and 1 is live";
    return done(invalid_argument("OUT_OF_RANGE", message.str(), "speed"));
  }
  impl_->on_strand(id, done, [speed, done](SheetRunner& r) {
    r.set_speed(speed);
    done(r.status());
  });
}

void Host::step(const std::string& id, std::int64_t ticks, Callback<SheetStatus> done, std::stop_token stop) {
  const std::int32_t limit = options().max_step_ticks;
  if (ticks < 1 || ticks > limit) {
    return done(invalid_argument(
        "OUT_OF_RANGE", "ticks is " + std::to_string(ticks) + "; must be in 1.." + std::to_string(limit), "ticks"));
  }
  impl_->on_strand(id, done, [ticks, done, stop = std::move(stop)](SheetRunner& r) { r.step(ticks, done, stop); });
}

void Host::inspect(const std::string& id, std::function<void(const sheet::Sheet&)> look, Callback<Nothing> done) {
  impl_->on_strand(id, done, [look = std::move(look), done](SheetRunner& r) {
    look(r.sheet());
    done(Nothing{});
  });
}

void Host::add_sink(const std::string& id, std::shared_ptr<sheet::SnapshotSink> sink, Callback<Nothing> done) {
  impl_->on_strand(id, done, [sink = std::move(sink), done](SheetRunner& r) {
    r.add_sink(sink);
    done(Nothing{});
  });
}

void Host::refresh_sink(const std::string& id, std::shared_ptr<sheet::SnapshotSink> sink, Callback<Nothing> done) {
  impl_->on_strand(id, done, [sink = std::move(sink), done](SheetRunner& r) {
    r.refresh_sink(sink);
    done(Nothing{});
  });
}

void Host::remove_sink(const std::string& id, std::shared_ptr<sheet::SnapshotSink> sink, Callback<Nothing> done) {
  impl_->on_strand(id, done, [sink = std::move(sink), done](SheetRunner& r) {
    r.remove_sink(sink);
    done(Nothing{});
  });
}

HostMetrics Host::metrics() const {
  return impl_->metrics();
}
double Host::load() const {
  return impl_->load();
}
const HostOptions& Host::options() const {
  return impl_->options();
}
void Host::wait_idle() {
  impl_->wait_idle();
}
void Host::stop() {
  impl_->stop();
}

}  // namespace kerf::host
