#include <memory>
#include <utility>

#include "server/service/host/host.h"
#include "server/service/host/sheet_runner.h"

// Keeps the sheets of a Host in its journal beyond the end of the process.
namespace kerf::host {

void Host::recover(StoredRun run, Callback<RecoveredSheet> done) {
  Creation made;
  made.paused = true;
  made.recovered = std::move(done);
  scene::SheetConfig config = run.config;
  std::string id = run.id;
  made.stored = std::make_shared<const StoredRun>(std::move(run));
  create(std::move(id), std::move(config), std::move(made));
}

void Host::start_recovered() {
  Runners runners;
  {
    const std::lock_guard lock(mutex_);
    runners = sheets_;
  }
  for (const auto& [id, runner] : runners) {
    if (runner) runner->post([](SheetRunner& r) { r.start_recovered(); }, [](const Error&) {});
  }
}

Status Host::keep_named(const StoredRun& run, const std::shared_ptr<const scene::SheetConfig>& config) {
  for (const SavedState& state : run.named) {
    auto kept = std::make_shared<SavedState>(state);
    kept->config = config;
    KERF_TRY(states_.add(run.id, std::move(kept), true));
  }
  return Nothing{};
}

void Host::mark(const Runners& runners) {
  std::vector<SheetMark> marks;
  for (const auto& [id, runner] : runners) {
    if (!runner) continue;
    // A sheet without a status is not stored yet.
    if (runner->last_status()) marks.push_back({runner->stored_sheet(), runner->reached_tick()});
  }
  if (!marks.empty()) options_.journal->mark(std::move(marks));
}

void Host::plan_to_mark() {
  const auto mark_all = [this, strand = workers_.make_strand()] {
    strand.post([this] {
      Runners runners;
      {
        const std::lock_guard lock(mutex_);
        mark_timer_.reset();
        runners = sheets_;
      }
      mark(runners);
      plan_to_mark();
    });
  };
  const std::lock_guard lock(mutex_);
  if (stopping_ || mark_timer_) return;
  mark_timer_ = clock_.schedule(clock_.now() + kMarkPeriod, mark_all);
}

}  // namespace kerf::host
