#include "server/service/host/host.h"

#include <sstream>
#include <utility>

#include "server/service/host/host_impl.h"

namespace kerf::host {

Host::Host(HostOptions options, Clock& clock, Entropy& entropy)
    : impl_(std::make_unique<Impl>(std::move(options), clock, entropy)) {}

Host::~Host() {
  stop();
}

void Host::create_sheet(std::string id, sheet::SheetConfig config, bool paused, Callback<SheetStatus> done,
                        const std::stop_token& stop) {
  impl_->create_sheet(std::move(id), std::move(config), nullptr, paused, std::move(done), stop);
}

void Host::replay(std::string id, sheet::Recording recording, bool paused, Callback<SheetStatus> done,
                  const std::stop_token& stop) {
  if (const Status ordered = sheet::check_order(recording.entries); !ordered.ok()) return done(ordered.error());
  auto playback = std::make_unique<Playback>(std::move(recording.entries), recording.torn_bytes);
  impl_->create_sheet(std::move(id), std::move(recording.config), std::move(playback), paused, std::move(done), stop);
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
  impl_->status(id, done);
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
  impl_->pause(id, done);
}

void Host::resume(const std::string& id, Callback<SheetStatus> done) {
  impl_->on_strand(id, done, [done](SheetRunner& r) {
    if (Status s = r.resume(); !s.ok()) return done(s.error());
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
bool Host::has_closed_sheets() const {
  return impl_->has_closed_sheets();
}

}  // namespace kerf::host
