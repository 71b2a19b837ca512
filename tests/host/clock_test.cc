#include "server/service/host/clock.h"

#include <condition_variable>
#include <mutex>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/manual_clock.h"

namespace kerf::host {
namespace {

using namespace std::chrono_literals;

TEST(ManualClock, FiresInOrderOfDeadlineThenOfSetting) {
  test::ManualClock clock;
  std::vector<int> fired;
  clock.schedule(30ms, [&] { fired.push_back(3); });
  clock.schedule(10ms, [&] { fired.push_back(1); });
  clock.schedule(10ms, [&] { fired.push_back(2); });
  const TimerId cancelled = clock.schedule(20ms, [&] { fired.push_back(9); });
  EXPECT_EQ(clock.next_deadline(), Nanoseconds(10ms));
  EXPECT_TRUE(clock.cancel(cancelled));
  EXPECT_FALSE(clock.cancel(cancelled));
  clock.move_to(25ms);
  EXPECT_EQ(fired, (std::vector<int>{1, 2}));
  clock.move_to(40ms);
  EXPECT_EQ(fired, (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(clock.num_timers(), 0U);
  EXPECT_EQ(clock.unix_us(), 40'000);
}

TEST(ManualClock, ATimerMaySetAnotherThatIsDueAlready) {
  test::ManualClock clock;
  int fired = 0;
  clock.schedule(1ms, [&] { clock.schedule(2ms, [&] { ++fired; }); });
  clock.move_to(5ms);
  EXPECT_EQ(fired, 1);
}

TEST(RealClock, FiresAndCancels) {
  RealClock clock;
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<int> fired;
  const auto note = [&](int which) {
    return [&, which] {
      const std::lock_guard lock(mutex);
      fired.push_back(which);
      changed.notify_all();
    };
  };
  const TimerId never = clock.schedule(clock.now() + 1h, note(9));
  const Nanoseconds begin = clock.now();
  clock.schedule(begin + 5ms, note(2));
  clock.schedule(begin - 1ms, note(1));
  {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return fired.size() == 2; });
  }
  EXPECT_EQ(fired, (std::vector<int>{1, 2}));
  EXPECT_GE(clock.now(), begin + 5ms);
  EXPECT_TRUE(clock.cancel(never));
  EXPECT_FALSE(clock.cancel(never));
  EXPECT_GE(clock.thread_cpu(), Nanoseconds(0));
}

}  // namespace
}  // namespace kerf::host
