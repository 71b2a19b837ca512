#include "client/load/run.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "client/cpp/client.h"
#include "client/cpp/failure.h"
#include "client/load/control.h"
#include "client/load/cut_tracker.h"
#include "client/load/cutter.h"
#include "client/load/delaying_proxy.h"
#include "client/load/ramp.h"
#include "client/load/sheet_set.h"
#include "client/load/sheet_switch.h"
#include "client/load/viewer.h"

namespace kerf::load {
namespace {

constexpr std::chrono::milliseconds kProgressEvery(250);
constexpr std::chrono::seconds kGrace(10);  // Longest wait, plus the delay, for frames that show the last cuts.
constexpr std::chrono::milliseconds kLookEvery(50);
constexpr double kLeastRun_s = 0.5;
constexpr std::size_t kProbes = 60;                    // Most probes in one run.
constexpr std::chrono::milliseconds kProbeEvery(500);  // Shortest time between probes.
constexpr std::size_t kMostSheetsListedOften = 1000;   // More are listed at the beginning and the end only.

Nanoseconds nanoseconds(double seconds) {
  return Nanoseconds(std::llround(1.0e9 * seconds));
}

std::string utc_now() {
  const std::time_t time = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm parts{};
  gmtime_r(&time, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text.data();
}

ErrorCode code_of(grpc::StatusCode code) {
  if (code == grpc::StatusCode::UNAVAILABLE) return ErrorCode::kUnavailable;
  if (code == grpc::StatusCode::UNAUTHENTICATED) return ErrorCode::kUnauthenticated;
  if (code == grpc::StatusCode::PERMISSION_DENIED) return ErrorCode::kPermissionDenied;
  return ErrorCode::kFailedPrecondition;
}

Error error_of(const grpc::Status& status, const std::string& server) {
  const client::Failure failure = client::failure_of(status);
  const bool unreached = failure.code == grpc::StatusCode::UNAVAILABLE;
  return {code_of(failure.code), failure.reason.empty() ? client::name_of(failure.code) : failure.reason,
          unreached
              ? "no server answers at " + server + " (" + failure.message + "): start kerfd, or give --server HOST:PORT"
              : failure.message,
          failure.field};
}

// Makes one run, in the order of its stages.
class Run {
 public:
  Run(const Plan& plan, const std::function<void(const Progress&)>& progress, Stopper& stopper)
      : progress_(progress),
        stopper_(stopper),
        client_(connect_to(plan.server, plan, client::Client::Connection::kShared)),
        probe_(report_.plan, client_) {
    report_.plan = plan;
  }

  Result<Report> all() {
    KERF_TRY(greet());
    const Nanoseconds begin = now();
    SheetSet sheets(report_.plan, client_, stopper_, [this](const char* stage, double share) {
      progress_({stage, share, 0, 0, 0});
    });
    report_.creation_s = 1e-9 * static_cast<double>((now() - begin).count());
    if (!sheets.failure().ok()) return error_of(sheets.failure(), report_.plan.server);
    report_.refusals = sheets.refusals();
    report_.first_refusal = sheets.first_refusal();
    report_.integrator = sheets.integrator();
    if (sheets.names().empty()) {
      return resource_exhausted(
          "NO_SHEETS",
          "no sheet was created: " + (report_.first_refusal.empty() ? "interrupted" : report_.first_refusal));
    }
    KERF_TRY(measure(sheets.names()));
    return std::move(report_);
  }

 private:
  Status greet() {
    v1::ServerInfo info;
    const grpc::Status status = client_.call(&v1::ServerService::Stub::GetServerInfo, client_.server(),
                                             v1::GetServerInfoRequest(), info, std::chrono::seconds(5));
    if (!status.ok()) return error_of(status, report_.plan.server);
    report_.server_version = info.version();
    report_.server_workers = info.workers();
    report_.processors = static_cast<std::int32_t>(std::thread::hardware_concurrency());
    report_.started = utc_now();
    return Nothing{};
  }

  Status measure(const std::vector<std::string>& names) {
    const Plan& plan = report_.plan;
    if (plan.way_ms > 0.0 || plan.way_kib_per_s > 0.0) {
      KERF_TRY_ASSIGN(
          proxy_, DelayingProxy::start(frames_at(), {nanoseconds(1e-3 * plan.way_ms), 1024.0 * plan.way_kib_per_s}));
    }
    Recorder recorder;
    CutTracker tracker(recorder);
    const bool in_stages = !plan.stages.empty();
    const bool sheets_in_stages = in_stages && plan.staged == Staged::kSheets;
    SheetSwitch running(names, sheets_in_stages ? 0 : static_cast<std::int32_t>(names.size()), client_, recorder);
    const auto set_viewers = [&](std::int32_t count) { this->set_viewers(count, names, recorder, tracker); };
    open_readers(names, recorder);
    if (!in_stages || sheets_in_stages) set_viewers(plan.viewers);
    // Starts the schedule only now: a thousand readers take a while to open, and events due meanwhile would be late.
    const Nanoseconds begin = now() + nanoseconds(plan.warm_up_s);
    recorder.measure(begin, begin + nanoseconds(plan.duration_s));
    report_.begin = begin;
    wait(begin, "warming up", recorder);
    {
      const Schedule ticks{begin, nanoseconds(1.0 / plan.tick_rate_hz)};
      const Control control(ticks, recorder.end(), stopper_);
      std::optional<Cutter> cutter;
      std::optional<Ramp> ramp;
      if (sheets_in_stages) {
        ramp.emplace(plan.stages, begin, stopper_, [&](std::int32_t count) { running.set(count); });
      } else if (in_stages) {
        ramp.emplace(plan.stages, begin, stopper_, set_viewers);
      }
      if (plan.cuts_per_second > 0.0) {
        cutter.emplace(plan, names, running.count(), client_, recorder, tracker, stopper_);
      }
      watch_over(recorder);
      report_.interrupted = stopper_.stopped();
      report_.window_s =
          1e-9 * static_cast<double>(std::max((std::min(now(), recorder.end()) - begin).count(), std::int64_t{1}));
      cutter.reset();  // All its answers have come.
      report_.control_us = control.lateness_us();
    }
    wait_for_cuts(tracker, recorder);
    stopper_.stop();
    for (const auto& viewer : viewers_) viewer->stop();
    for (const auto& reader : readers_) reader->stop();
    viewers_.clear();
    readers_.clear();
    proxy_.reset();
    tracker.finish();
    collect(recorder);
    if (sheets_in_stages) set_paces(names, running);
    return Nothing{};
  }

  // Divides the ticks of each sheet by the time for which it was to run; a shorter one than kLeastRun_s says little.
  void set_paces(const std::vector<std::string>& names, const SheetSwitch& running) {
    for (SheetRun& sheet : report_.sheets) {
      const auto index = static_cast<std::size_t>(std::find(names.begin(), names.end(), sheet.name) - names.begin());
      const double ran_s = running.ran_s(index, last_listed_);
      const double simulated_s = static_cast<double>(sheet.ticks) / report_.plan.tick_rate_hz;
      sheet.real_time_factor = ran_s >= kLeastRun_s ? simulated_s / ran_s : 0.0;
    }
  }

  void open_readers(const std::vector<std::string>& names, Recorder& recorder) {
    const Plan& plan = report_.plan;
    const auto open = [&](Role role, std::int32_t count) {
      for (std::int32_t i = 0; i < count; ++i) {
        readers_.push_back(open_reader(watching_of(role, static_cast<std::size_t>(i), names), recorder));
      }
    };
    open(Role::kSlow, plan.slow_readers);
    open(Role::kStalled, plan.stalled_readers);
    open(Role::kImage, plan.image_viewers);
  }

  // Returns what reader number `i` of a role watches.
  [[nodiscard]] Watching watching_of(Role role, std::size_t i, const std::vector<std::string>& names) const {
    Watching watching;
    watching.role = role;
    watching.index = i % names.size();
    watching.sheet = names[watching.index];
    watching.address = role == Role::kImage ? report_.plan.server : proxy_ ? proxy_->address() : frames_at();
    return watching;
  }

  // Opens or closes viewers until there are `count`; the last opened closes first.
  void set_viewers(std::int32_t count, const std::vector<std::string>& names, Recorder& recorder, CutTracker& tracker) {
    const auto wanted = static_cast<std::size_t>(count);
    while (viewers_.size() < wanted) {
      Watching watching = watching_of(Role::kViewer, viewers_.size(), names);
      if (viewers_.size() < names.size()) {  // The first viewer of its sheet.
        tracker.watch(watching.index);
        watching.tracker = &tracker;
      }
      viewers_.push_back(open_reader(watching, recorder));
    }
    while (viewers_.size() > wanted) {
      viewers_.pop_back();
      if (viewers_.size() < names.size()) tracker.unwatch(viewers_.size());
    }
  }

  // Returns the address for readers of frames, without a proxy.
  [[nodiscard]] const std::string& frames_at() const {
    return report_.plan.transport == Transport::kGrpc ? report_.plan.server : report_.plan.http;
  }

  std::unique_ptr<Viewer> open_reader(const Watching& watching, Recorder& recorder) {
    if (watching.role == Role::kImage) return watch_images(report_.plan, watching, recorder);
    const auto watch = report_.plan.transport == Transport::kGrpc ? watch_frames : watch_frames_over_websocket;
    return watch(report_.plan, watching, recorder, stopper_);
  }

  void wait(Nanoseconds until, const char* stage, const Recorder& recorder) {
    const Nanoseconds from = now();
    while (now() < until && stopper_.wait_until(std::min(until, now() + kProgressEvery))) {
      tell(stage, from, until, recorder);
    }
  }

  // Waits for frames that show the last cuts and are still in transit to viewers.
  void wait_for_cuts(const CutTracker& tracker, const Recorder& recorder) {
    const Nanoseconds from = now();
    const Nanoseconds end = from + kGrace + nanoseconds(1e-3 * report_.plan.way_ms);
    while (tracker.num_waiting() > 0 && now() < end && stopper_.wait_until(now() + kLookEvery)) {
      tell("last cuts", from, end, recorder);
    }
  }

  // Probes the server during the measurement.
  void watch_over(const Recorder& recorder) {
    first_ = probe_.sheets();
    first_listed_ = now();
    add_probe(first_);
    const Nanoseconds begin = recorder.begin();
    const Nanoseconds every = std::max<Nanoseconds>((recorder.end() - begin) / kProbes, kProbeEvery);
    for (Nanoseconds next = begin + every; next < recorder.end(); next += every) {
      while (now() < next && stopper_.wait_until(std::min(next, now() + kProgressEvery))) {
        tell("measuring", begin, recorder.end(), recorder);
      }
      if (stopper_.stopped()) break;
      if (first_.size() <= kMostSheetsListedOften) add_probe(probe_.sheets());
    }
    wait(recorder.end(), "measuring", recorder);
    // Lists the sheets after the last reading: listing ten thousand takes more CPU time than they do asleep.
    Probe last = probe_.probe();
    last_ = probe_.sheets();
    last_listed_ = now();
    add_sums(last_, last);
    report_.probes.push_back(std::move(last));
  }

  void add_probe(const std::map<std::string, SheetCounts>& sheets) {
    Probe probe = probe_.probe();
    add_sums(sheets, probe);
    report_.probes.push_back(std::move(probe));
  }

  void collect(const Recorder& recorder) {
    report_.measured_s = 1e-9 * static_cast<double>((last_listed_ - first_listed_).count());
    for (const auto& [name, last] : last_) {
      const auto first = first_.find(name);
      if (first == first_.end()) continue;
      SheetRun sheet{name,
                     last.run_state,
                     last.tick - first->second.tick,
                     last.overruns - first->second.overruns,
                     last.slipped_s - first->second.slipped_s,
                     0.0};
      sheet.real_time_factor = static_cast<double>(sheet.ticks) / report_.plan.tick_rate_hz / report_.measured_s;
      report_.sheets.push_back(std::move(sheet));
    }
    for (const Role role : kRoles) report_.readers[static_cast<std::size_t>(role)] = recorder.readers(role);
    report_.cuts = recorder.cut_totals();
    report_.stretches = recorder.stretches();
    report_.errors = recorder.errors();
    if (probe_.failure()) ++report_.errors["probe " + client::reason_of(*probe_.failure())];
    report_.list_pages = probe_.pages();
    report_.list_s = 1e-9 * static_cast<double>(probe_.listing_took().count());
  }

  void tell(const char* stage, Nanoseconds from, Nanoseconds to, const Recorder& recorder) const {
    const double share = static_cast<double>((now() - from).count()) / static_cast<double>((to - from).count());
    Progress progress{stage, std::clamp(share, 0.0, 1.0), 0, recorder.cut_totals().reply_us.count(), 0};
    for (const Role role : kRoles) progress.frames += recorder.readers(role).frames;
    for (const auto& [reason, count] : recorder.errors()) progress.errors += count;
    progress_(progress);
  }

  Report report_;
  const std::function<void(const Progress&)>& progress_;
  Stopper& stopper_;
  client::Client client_;
  ServerProbe probe_;
  std::unique_ptr<DelayingProxy> proxy_;
  std::vector<std::unique_ptr<Viewer>> viewers_;  // Readers at full speed; the Ramp changes them.
  std::vector<std::unique_ptr<Viewer>> readers_;  // All others.
  std::map<std::string, SheetCounts> first_;
  std::map<std::string, SheetCounts> last_;
  Nanoseconds first_listed_{0};
  Nanoseconds last_listed_{0};
};

}  // namespace

Result<Report> run(const Plan& plan, const std::function<void(const Progress&)>& progress, Stopper& stopper) {
  KERF_TRY(check(plan));
  return Run(plan, progress, stopper).all();
}

}  // namespace kerf::load
