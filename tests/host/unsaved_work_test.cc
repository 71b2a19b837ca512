// Tests of what sheets leave to a restart to repeat.
#include "server/service/host/unsaved_work.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "tests/host/fake_journal.h"
#include "tests/host/fixture.h"

namespace kerf::host {
namespace {

TEST(UnsavedWork, IsTheSumOfItsShares) {
  UnsavedWork all;
  EXPECT_EQ(all.mean(), 0ns);
  UnsavedShare idle(all);
  UnsavedShare first(all);
  first.add(3ms);
  first.add(3ms);
  {
    UnsavedShare second(all);
    second.add(2ms);
    EXPECT_EQ(all.total(), 8ms);
    EXPECT_EQ(all.mean(), 4ms) << "a sheet without work does not count";
  }
  EXPECT_EQ(all.mean(), 6ms);
  first.clear();
  first.clear();
  EXPECT_EQ(all.total(), 0ns);
  EXPECT_EQ(all.mean(), 0ns);
}

// Each question for the CPU time takes 1 ms of it.
class WorkingClock : public test::ManualClock {
 public:
  [[nodiscard]] Nanoseconds thread_cpu() const override { return Nanoseconds(++calls_ * 1'000'000); }

 private:
  mutable std::atomic<std::int64_t> calls_{0};
};

// Runs sheets, and returns the ticks that are not saved: the largest sum at any time, and the largest of one sheet.
struct UnsavedTicks {
  std::int64_t sum = 0;
  std::int64_t one = 0;
};
UnsavedTicks unsaved_ticks(int num_sheets) {
  WorkingClock clock;
  SeededEntropy entropy(1);
  FakeJournal journal;
  HostOptions options = with_journal(journal);
  options.workers = 1;
  options.max_unsaved_cpu = 400ms;
  Host host(std::move(options), clock, entropy);
  for (int i = 0; i < num_sheets; ++i) {
    host.create_sheet("sheet-" + std::to_string(i), scenes::hanging(4), false, [](const auto&) {});
    host.wait_idle();
  }
  UnsavedTicks most;
  for (int tick = 0; tick < 400; ++tick) {
    clock.move_to(*clock.next_deadline());
    host.wait_idle();
    std::int64_t sum = 0;
    for (const auto& [number, kept] : journal.sheets()) {
      const auto state = kept.states.find("");
      const std::int64_t saved = state == kept.states.end() ? 0 : state->second.tick;
      const std::int64_t unsaved = host.statuses({kept.made.id}).at(0).tick - saved;
      most.one = std::max(most.one, unsaved);
      sum += unsaved;
    }
    most.sum = std::max(most.sum, sum);
  }
  host.stop();
  return most;
}

TEST(UnsavedWork, OfManySheetsIsNoMoreThanThatOfOne) {
  const UnsavedTicks alone = unsaved_ticks(1);
  const UnsavedTicks shared = unsaved_ticks(5);
  EXPECT_GT(alone.sum, 20);
  EXPECT_LE(shared.sum, alone.sum + 10);
  EXPECT_GT(shared.sum, alone.sum / 2) << "they are saved more often than they need to be";
  EXPECT_LT(shared.one, alone.sum);
}

}  // namespace
}  // namespace kerf::host
