// Ticks that take long, and what ends them.
#include <atomic>
#include <functional>
#include <future>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "server/core/sheet/recording.h"
#include "tests/host/fixture.h"
#include "tests/support/failing_integrator.h"

namespace kerf::host {
namespace {

constexpr int kVertices = 25;  // of small_sheet()

struct Watched {
  std::atomic<int> begun = 0;           // steps that do not end by themselves
  std::atomic<std::int64_t> asked = 0;  // Times that they polled the stop condition.
};

// Never ends a step of a sheet that is cut, unless it is asked to.
class Endless : public scenes::FailingIntegrator {
 public:
  Endless(const fem::IntegratorOptions& options, std::shared_ptr<Watched> watched)
      : FailingIntegrator(options), watched_(std::move(watched)) {}

  fem::StepStats step(const fem::Model& model, const fem::Loads& loads, double dt, fem::ContactConstraint* contact,
                      fem::State& state) override {
    if (model.num_vertices() == kVertices) return FailingIntegrator::step(model, loads, dt, contact, state);
    ++watched_->begun;
    while (!stop_.is_met()) {
      ++watched_->asked;
      std::this_thread::yield();
    }
    fem::StepStats stats;
    stats.interrupted = true;
    return stats;
  }

 private:
  std::shared_ptr<Watched> watched_;
};

class LongTickTest : public HostTest {
 protected:
  using Entries = std::vector<sheet::RecordedTick>;

  LongTickTest() : LongTickTest(std::make_shared<Watched>(), std::make_shared<Entries>()) {}

  static scene::Command cut() { return scenes::line_cut({0.2, 0.5}, {0.8, 0.4}); }

  // Sheet a, in the middle of the tick that cuts it; not long yet.
  void begin_long_tick() {
    create("a", small_sheet());
    run_for(5 * kTick);
    host_->submit("a", cut(), cut_.callback());
    begin_next_tick();
  }
  void begin_next_tick() {
    const int begun = watched_->begun;
    clock_.move_to(std::max(clock_.now(), clock_.next_deadline().value()));
    until_begun(begun + 1);
  }
  void until_begun(int count) const {
    while (watched_->begun < count) std::this_thread::yield();
  }
  void let_it_ask() const {
    const std::int64_t asked = watched_->asked;
    while (watched_->asked < asked + 100) std::this_thread::yield();
  }
  void let_it_be_long() { clock_.move_to(clock_.now() + Host::kLongTick + 1ms); }

  std::shared_ptr<Watched> watched_;
  std::shared_ptr<Entries> entries_;
  Answers<CommandResult> cut_;

 private:
  LongTickTest(const std::shared_ptr<Watched>& watched, const std::shared_ptr<Entries>& entries)
      : HostTest(endless(watched, entries)), watched_(watched), entries_(entries) {}

  static HostOptions endless(const std::shared_ptr<Watched>& watched, const std::shared_ptr<Entries>& entries) {
    HostOptions options;
    options.make_integrator = [watched](const fem::IntegratorOptions& wanted) {
      return std::make_unique<Endless>(wanted, watched);
    };
    options.encode_tick = [entries](const sheet::RecordedTick& entry) {
      entries->push_back(entry);
      return std::string("e");
    };
    return options;
  }
};

TEST_F(LongTickTest, IsEndedByAPauseAndKeepsItsCommands) {
  begin_long_tick();
  Answers<SheetStatus> paused;
  host_->pause("a", paused.callback());
  let_it_ask();
  EXPECT_EQ(paused.count(), 0U) << "it may be over in a moment";
  let_it_be_long();
  host_->wait_idle();
  ASSERT_EQ(paused.count(), 1U);
  EXPECT_EQ(paused.at(0)->run_state, RunState::kPaused);
  EXPECT_EQ(paused.at(0)->tick, cut_.at(0)->reply.tick);
  EXPECT_GT(paused.at(0)->num_vertices, kVertices);
  const std::int64_t ticks = paused.at(0)->tick;

  ASSERT_TRUE(submit("a", scene::UndoCut{}).ok());
  Answers<SheetStatus> resumed;
  host_->resume("a", resumed.callback());
  run_for(5 * kTick);
  EXPECT_GT(status("a").tick, ticks);
}

TEST_F(LongTickTest, KeepsNoStatusWaiting) {
  begin_long_tick();
  let_it_be_long();
  Answers<SheetStatus> statuses;
  host_->status("a", statuses.callback());
  ASSERT_EQ(statuses.count(), 1U);
  EXPECT_EQ(statuses.at(0)->num_vertices, kVertices) << "as it was before";
  EXPECT_FALSE(statuses.at(0)->state_hash);

  Answers<CommandResult> undone;
  host_->submit("a", scene::UndoCut{}, undone.callback());
  host_->wait_idle();
  EXPECT_TRUE(status("a").state_hash) << "between two ticks, however long the last one was";
  host_->submit("a", cut(), cut_.callback());
  begin_next_tick();
  host_->status("a", statuses.callback());
  EXPECT_EQ(statuses.count(), 1U) << "the tick before was short, and this one is not long yet";
  let_it_be_long();
  Answers<SheetStatus> paused;
  host_->pause("a", paused.callback());
  host_->wait_idle();
  EXPECT_EQ(statuses.count(), 2U);
  host_->resume("a", statuses.callback());
  until_begun(3);
  host_->status("a", statuses.callback());
  EXPECT_EQ(statuses.count(), 4U) << "the tick before was long";
}

TEST_F(LongTickTest, IsEndedByAnUndoWhichTakesTheCutBack) {
  begin_long_tick();
  let_it_be_long();
  Answers<CommandResult> undone;
  host_->submit("a", scene::UndoCut{}, undone.callback());
  host_->wait_idle();
  ASSERT_EQ(undone.reason(0), "done");
  EXPECT_EQ(undone.at(0)->reply.tick, cut_.at(0)->reply.tick + 1);
  run_for(5 * kTick);
  EXPECT_EQ(status("a").num_vertices, kVertices);
}

TEST_F(LongTickTest, IsNotEndedByOtherCommands) {
  begin_long_tick();
  let_it_be_long();
  Answers<CommandResult> wind;
  host_->submit("a", scene::SetWind{}, wind.callback());
  let_it_ask();
  EXPECT_EQ(watched_->begun, 1);
  EXPECT_EQ(wind.count(), 0U);
}

TEST_F(LongTickTest, IsEndedByDeletion) {
  begin_long_tick();
  Answers<Nothing> deleted;
  host_->delete_sheet("a", deleted.callback());
  host_->wait_idle();
  EXPECT_EQ(deleted.reason(0), "done");
}

TEST_F(LongTickTest, IsEndedByTheHostsEnd) {
  begin_long_tick();
  host_->stop();
  EXPECT_EQ(cut_.reason(0), "done");
}

TEST_F(LongTickTest, OfAStepCallIsEndedWhenThatIsNotWantedAnyMore) {
  create("a", small_sheet(), true);
  ASSERT_TRUE(submit("a", cut()).ok());
  std::stop_source source;
  Answers<SheetStatus> stepped;
  host_->step("a", 10, stepped.callback(), source.get_token());
  until_begun(1);
  EXPECT_EQ(stepped.count(), 0U);
  source.request_stop();
  host_->wait_idle();
  EXPECT_EQ(stepped.at(0)->tick, 0);
}

// Pauses when it is given the snapshot of tick 1.
class PauseAfterTick1 : public RecordingSnapshots {
 public:
  PauseAfterTick1(Host& host, Callback<SheetStatus> done) : host_(host), done_(std::move(done)) {}
  void publish(std::shared_ptr<const sheet::Snapshot> snapshot) override {
    if (snapshot->tick == 1 && !std::exchange(has_paused_, true)) host_.pause("a", done_);
  }

 private:
  Host& host_;
  Callback<SheetStatus> done_;
  bool has_paused_ = false;
};

TEST_F(LongTickTest, IsEndedByAPauseThatCameBeforeItInTheSameTurn) {
  create("a", small_sheet(), true);
  Answers<std::int64_t> scheduled;
  host_->schedule("a", cut(), 2, scheduled.callback());
  Answers<SheetStatus> paused;
  Answers<Nothing> added;
  host_->add_sink("a", std::make_shared<PauseAfterTick1>(*host_, paused.callback()), added.callback());
  Answers<SheetStatus> stepped;
  host_->step("a", 10, stepped.callback());
  until_begun(1);
  let_it_be_long();
  host_->wait_idle();
  ASSERT_EQ(paused.count(), 1U);
  EXPECT_EQ(paused.at(0)->tick, 1);
  EXPECT_EQ(stepped.at(0)->tick, 1);
}

TEST_F(LongTickTest, IsEndedByAPauseThatWaitedBehindIt) {
  create("a", small_sheet());
  run_for(5 * kTick);
  host_->submit("a", cut(), cut_.callback());
  // Workers are busy while the tick and the pause wait for one.
  std::vector<std::promise<void>> gates(static_cast<std::size_t>(host_->options().workers));
  Answers<Nothing> opened;
  for (std::size_t i = 0; i < gates.size(); ++i) create("gate-" + std::to_string(i), small_sheet(), true);
  for (std::size_t i = 0; i < gates.size(); ++i) {
    host_->inspect(
        "gate-" + std::to_string(i), [open = gates[i].get_future().share()](const auto&) { open.wait(); },
        opened.callback());
  }
  clock_.move_to(std::max(clock_.now(), clock_.next_deadline().value()));
  Answers<SheetStatus> paused;
  host_->pause("a", paused.callback());
  for (std::promise<void>& gate : gates) gate.set_value();
  until_begun(1);
  let_it_be_long();
  host_->wait_idle();
  EXPECT_EQ(paused.at(0)->run_state, RunState::kPaused);
}

TEST_F(LongTickTest, DoesNotDelayTheOneThatTakesItsPlace) {
  create("a", small_sheet());
  run_for(5 * kTick);
  Answers<SheetStatus> slowed;
  host_->set_speed("a", Host::kMinSpeed, slowed.callback());
  run_for(kTick);
  const Nanoseconds period = Nanoseconds(100 * kTick);
  host_->submit("a", cut(), cut_.callback());
  begin_next_tick();
  const Nanoseconds begun = clock_.now();
  let_it_be_long();
  Answers<CommandResult> undone;
  host_->submit("a", scene::UndoCut{}, undone.callback());
  host_->wait_idle();
  ASSERT_EQ(undone.reason(0), "done");
  EXPECT_EQ(clock_.next_deadline().value(), begun + period);
  EXPECT_EQ(status("a").stats.slipped_s, 0.0);
}

TEST_F(LongTickTest, OfAReplayIsNoDivergenceWhereDeletionEndsIt) {
  const std::vector<sheet::RecordedTick> entries = {{3, {cut()}, 1}, {9, {}, 1}};
  Answers<SheetStatus> made;
  host_->replay("r", {small_sheet(), entries}, true, made.callback());
  host_->wait_idle();
  ASSERT_EQ(made.reason(0), "done");
  Answers<SheetStatus> stepped;
  host_->step("r", 10, stepped.callback());
  until_begun(1);
  Answers<SheetStatus> asked;
  host_->status("r", asked.callback());
  Answers<Nothing> deleted;
  host_->delete_sheet("r", deleted.callback());
  host_->wait_idle();
  EXPECT_EQ(deleted.reason(0), "done");
  EXPECT_EQ(stepped.reason(0), "SHEET_DELETED");
  EXPECT_EQ(asked.at(0)->replay->state, ReplayState::kPlaying);
}

// A clock whose next thread_cpu(), which is asked for when a tick has taken its commands, does something first.
class HookedClock : public test::ManualClock {
 public:
  Nanoseconds thread_cpu() const override {
    if (const std::function<void()> hook = std::exchange(hook_, nullptr)) hook();
    return ManualClock::thread_cpu();
  }
  void hook(std::function<void()> call) { hook_ = std::move(call); }

 private:
  mutable std::function<void()> hook_;
};

TEST_F(LongTickTest, IsEndedByAnUndoThatCameJustTooLateForIt) {
  HookedClock clock;
  Host host(host_->options(), clock, entropy_);
  Answers<SheetStatus> made;
  host.create_sheet("a", small_sheet(), false, made.callback());
  host.wait_idle();
  host.submit("a", cut(), cut_.callback());
  Answers<CommandResult> undone;
  clock.hook([&] { host.submit("a", scene::UndoCut{}, undone.callback()); });
  clock.move_to(clock.next_deadline().value());
  until_begun(1);
  clock.move_to(clock.now() + Host::kLongTick + 1ms);
  host.wait_idle();
  EXPECT_EQ(undone.reason(0), "done");
}

// Tests both cases: the tick before was recorded, or not.
TEST_F(LongTickTest, LeavesARecordingThatReplays) {
  begin_long_tick();
  for (int round = 0; round < 3; ++round) {
    let_it_be_long();
    Answers<SheetStatus> paused;
    host_->pause("a", paused.callback());
    host_->wait_idle();
    ASSERT_TRUE(submit("a", scene::UndoCut{}).ok());
    ASSERT_TRUE(submit("a", scene::SetWind{{{1.0 + round, 0.0, 0.0}, 1.2, 1.0}}).ok());
    Answers<SheetStatus> resumed;
    host_->resume("a", resumed.callback());
    run_for(round * kTick);
    Answers<CommandResult> drawn;
    host_->submit("a", scene::SetWind{{{0.0, 1.0 + round, 0.0}, 1.2, 1.0}}, drawn.callback());
    host_->submit("a", cut(), cut_.callback());
    begin_next_tick();
  }
  let_it_be_long();
  Answers<SheetStatus> paused;
  host_->pause("a", paused.callback());
  Answers<KeptRun> run;
  host_->recording("a", run.callback());
  host_->wait_idle();
  ASSERT_EQ(run.reason(0), "done");
  const Result<sheet::ReplayReport> report = sheet::replay({*run.at(0)->config, *entries_});
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_FALSE(report->divergence) << "at entry " << report->divergence->entry;
  EXPECT_EQ(report->ticks, paused.at(0)->tick);
}

}  // namespace
}  // namespace kerf::host
