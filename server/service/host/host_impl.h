#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "server/service/host/admission.h"
#include "server/service/host/host.h"
#include "server/service/host/metrics_board.h"
#include "server/service/host/sheet_runner.h"
#include "server/service/host/vertex_budget.h"
#include "server/service/host/workers.h"

// Keeps the sheets and posts calls to the strand of each; used by host.cc and host_impl.cc alone.
namespace kerf::host {

class Host::Impl {
 public:
  Impl(HostOptions options, Clock& clock, Entropy& entropy)
      : options_(std::move(options)),
        clock_(clock),
        entropy_(entropy),
        vertices_(options_.max_total_vertices),
        admission_(options_.max_load),
        workers_({.num_threads = options_.workers, .patience = options_.long_work}),
        builders_({.patience = options_.long_work, .max_taken_on = kMaxBuilders - 1, .is_background = true}) {}

  // `playback`: the recording that the sheet is to play; null: none.
  void create_sheet(std::string id, sheet::SheetConfig config, std::unique_ptr<Playback> playback, bool paused,
                    Callback<SheetStatus> done, const std::stop_token& stop);
  void delete_sheet(const std::string& id, Callback<Nothing> done, std::function<void()> closed);
  [[nodiscard]] std::vector<std::string> list() const;
  [[nodiscard]] std::vector<SheetStatus> statuses(const std::vector<std::string>& ids) const;
  void submit(const std::string& id, sheet::Command command, Callback<CommandResult> done);
  void schedule(const std::string& id, sheet::Command command, std::int64_t at_tick,
                const Callback<std::int64_t>& done);

  void release_grab(const std::string& id, std::string grab_id) {
    if (const std::shared_ptr<SheetRunner> runner = find(id)) runner->release_grab(std::move(grab_id));
  }

  // Runs `work` on the sheet's strand; `done` receives the error if that is impossible.
  template <typename T>
  void on_strand(const std::string& id, const Callback<T>& done, std::function<void(SheetRunner&)> work) {
    const std::shared_ptr<SheetRunner> runner = find(id);
    if (!runner) return done(missing(id));
    runner->post(std::move(work), [done](Error error) { done(std::move(error)); });
  }
  void status(const std::string& id, const Callback<SheetStatus>& done);
  void pause(const std::string& id, const Callback<SheetStatus>& done);

  void set_command_listener(CommandListener listener) { listener_.set(std::move(listener)); }
  [[nodiscard]] HostMetrics metrics() const { return board_.read(); }
  [[nodiscard]] double load() const {
    return static_cast<double>(board_.worker_need()) / (static_cast<double>(WorkerNeed::kWhole) * options_.workers);
  }
  [[nodiscard]] const HostOptions& options() const { return options_; }
  // Waits for the builders first, because they post to the workers.
  void wait_idle() {
    builders_.wait_idle();
    workers_.wait_idle();
  }
  void stop();
  [[nodiscard]] bool has_closed_sheets() const { return has_closed_sheets_; }

 private:
  // Describes a requested sheet until it is one of `sheets_`.
  struct Creation {
    std::string id;
    std::shared_ptr<VertexShare> vertices;  // Null: neither vertices nor the name are reserved.
    std::shared_ptr<ExpectedNeed> need;
    std::unique_ptr<Playback> playback;
    bool paused = false;
    Callback<SheetStatus> done;
    std::stop_token stop;
  };
  static constexpr Nanoseconds kReleaseDelay = std::chrono::seconds(2);
  // Limit on sheets being built at the same time; others wait.
  static constexpr std::size_t kMaxBuilders = 3;

  SheetRunner::Context context() {
    return {options_,   clock_, board_, listener_, slip_, stopping_, [this](const std::string& id) { release(id); },
            ++num_made_};
  }

  std::shared_ptr<ExpectedNeed> expected_need(const sheet::SheetConfig& config);
  // Reserves the name, and the vertices known so far.
  Result<std::shared_ptr<VertexShare>> reserve(const std::string& id, const sheet::SheetConfig& config, bool paused);
  Result<sheet::Sheet> build(sheet::SheetConfig config, const Creation& creation);
  // Returns an error if the sheet being built is no longer wanted.
  Status check_wanted(const Creation& creation) const;
  // Builds the sheet on a builder thread, then posts begin() to a worker.
  Status build_and_hand_on(const std::shared_ptr<Creation>& creation, sheet::SheetConfig config);
  Result<SheetStatus> begin(Creation& creation, sheet::Sheet sheet, const Workers::Strand& strand);
  void refuse(Creation& creation, const Error& error);
  void release(const std::string& id);
  // Schedules the return of free memory to the system, once for all sheets that end until then.
  void plan_to_release_memory();
  bool admit(const std::string& id, const std::shared_ptr<SheetRunner>& runner);
  [[nodiscard]] std::shared_ptr<SheetRunner> find(const std::string& id) const;
  [[nodiscard]] Error missing(const std::string& id) const;

  const HostOptions options_;
  Clock& clock_;
  Entropy& entropy_;
  MetricsBoard board_;
  VertexBudget vertices_;
  ListenerSlot listener_;
  SharedSlip slip_;
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<SheetRunner>> sheets_;  // Null: being built or deleted. Guarded by mutex_.
  std::atomic<std::uint64_t> num_made_{0};
  std::atomic<std::int64_t> promised_bytes_{0};  // Bytes promised to sheets being built.
  std::atomic<bool> stopping_{false};            // Set under mutex_.
  std::atomic<bool> has_closed_sheets_{false};
  Admission admission_;                   // guarded by mutex_
  std::optional<TimerId> release_timer_;  // guarded by mutex_
  Workers workers_;                       // Declared after everything that its threads use.
  Workers builders_;                      // Build sheets, and post them to the workers.
};

}  // namespace kerf::host
