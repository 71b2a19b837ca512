#include <atomic>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "tests/host/fixture.h"
#include "tests/support/failing_integrator.h"

// Tests that a stopping host starts no new work, however many sheets it has.
namespace kerf::host {
namespace {

// Counts all integrators, which live as long as their sheets.
struct Lives {
  std::atomic<int> begun = 0;
  std::atomic<int> ended_on_workers = 0;
  std::atomic<int> ended_elsewhere = 0;  // on the test's thread, which stops the host
};

class Counted : public scenes::FailingIntegrator {
 public:
  Counted(const fem::IntegratorOptions& options, std::shared_ptr<Lives> lives, std::thread::id elsewhere)
      : FailingIntegrator(options), lives_(std::move(lives)), elsewhere_(elsewhere) {
    ++lives_->begun;
  }
  ~Counted() override {
    ++(std::this_thread::get_id() == elsewhere_ ? lives_->ended_elsewhere : lives_->ended_on_workers);
  }

 private:
  std::shared_ptr<Lives> lives_;
  std::thread::id elsewhere_;
};

HostOptions counting(const std::shared_ptr<Lives>& lives) {
  HostOptions options;
  options.workers = 1;
  options.long_work = 0ms;  // Work that waits for the only worker keeps waiting.
  options.max_load = 0.0;
  options.make_integrator = [lives, elsewhere = std::this_thread::get_id()](const fem::IntegratorOptions& wanted) {
    return std::make_unique<Counted>(wanted, lives, elsewhere);
  };
  return options;
}

class HostStopTest : public HostTest {
 protected:
  static constexpr int kSheets = 40;

  HostStopTest() : HostStopTest(std::make_shared<Lives>()) {}

  std::shared_ptr<Lives> lives_;

 private:
  explicit HostStopTest(const std::shared_ptr<Lives>& lives) : HostTest(counting(lives)), lives_(lives) {}
};

// With thousands of sheets, what waits for a worker when the signal comes would take longer than a stop may.
TEST_F(HostStopTest, WhatIsDueIsNotDone) {
  for (int i = 0; i < kSheets; ++i) create("s" + std::to_string(i), small_sheet());
  create("gate", small_sheet(), true);
  create("stepped", small_sheet(), true);
  const std::int64_t ticks = host_->metrics().ticks;
  const int begun = lives_->begun;

  std::promise<void> release;
  Answers<Nothing> opened;
  host_->inspect(
      "gate", [open = release.get_future().share()](const auto&) { open.wait(); }, opened.callback());
  clock_.move_to(clock_.now() + 2 * kTick);  // every sheet is due, and waits for the only worker
  Answers<SheetStatus> answers;
  host_->step("stepped", 1'000, answers.callback());
  host_->create_sheet("late", small_sheet(), false, answers.callback());
  std::thread stopping([&] { host_->stop(); });
  while (!host_->list().empty()) std::this_thread::yield();  // until it has begun
  release.set_value();
  stopping.join();

  EXPECT_EQ(host_->metrics().ticks, ticks);
  EXPECT_LE(lives_->begun, begun + 1) << "builders do not wait for the worker, and one had begun";
  ASSERT_EQ(answers.count(), 2U);
  EXPECT_EQ(answers.reason(0), "HOST_STOPPING");
  EXPECT_EQ(answers.reason(1), "HOST_STOPPING");
  EXPECT_EQ(host_->metrics().sheets, 0);
}

// Freeing what thousands of sheets hold takes seconds: all workers do it, and not whoever stops the host alone.
TEST_F(HostStopTest, WorkersTakeTheSheetsDown) {
  for (int i = 0; i < kSheets; ++i) create("s" + std::to_string(i), small_sheet(), i % 2 == 0);
  host_->stop();
  EXPECT_EQ(lives_->ended_on_workers, lives_->begun);
  EXPECT_EQ(lives_->ended_elsewhere, 0);
  EXPECT_GE(lives_->begun, kSheets);
}

}  // namespace
}  // namespace kerf::host
