#include <sys/resource.h>

#include <condition_variable>
#include <csignal>
#include <filesystem>
#include <mutex>
#include <set>

#include <gtest/gtest.h>

#include "server/base/disk.h"
#include "server/service/host/clock.h"
#include "server/service/host/entropy.h"
#include "server/service/host/manual_clock.h"
#include "server/service/host/metrics.h"
#include "server/service/host/pace.h"
#include "tests/support/temporary_folder.h"

namespace kerf::host {
namespace {

using namespace std::chrono_literals;

TEST(ManualClock, FiresInOrderOfDeadlineThenOfSetting) {
  ManualClock clock;
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
  ManualClock clock;
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

// Three sheets of one period, each after the other in its turn on a machine that lets them compute a tenth of the time.
TEST(Pace, WhatOneLosesToTheMachineAllLose) {
  SharedSlip shared;
  std::vector<Pace> paces(3, Pace(10ms, shared));
  const std::vector<Nanoseconds> cpu{50us, 400us, 2ms};
  Nanoseconds now = 0ns;
  std::vector<int> ticks(paces.size());
  while (now < 60s) {
    bool any = false;
    for (std::size_t i = 0; i < paces.size(); ++i) {
      if (paces[i].deadline() > now) continue;
      any = true;
      now += 10 * cpu[i];
      paces[i].tick_done(now, cpu[i], 1.0);
      ++ticks[i];
    }
    if (!any) now += 1ms;
  }
  EXPECT_LT(ticks[0], 4000) << "the machine is too slow for them";
  EXPECT_NEAR(ticks[1], ticks[0], 0.02 * ticks[0]);
  EXPECT_NEAR(ticks[2], ticks[0], 0.02 * ticks[0]);
  EXPECT_NEAR(seconds(paces[1].slipped()), seconds(paces[0].slipped()), 0.5);
}

TEST(Pace, WhatATickTakesByItselfIsNoLossOfOthers) {
  SharedSlip shared;
  Pace heavy(10ms, shared);
  for (Nanoseconds now = 0ns; now < 10s; now += 30ms) heavy.tick_done(now + 30ms, 30ms, 1.0);
  EXPECT_GT(seconds(heavy.slipped()), 6.0);
  EXPECT_EQ(shared.total(), 0ns);
  Pace starved(10ms, shared);
  for (Nanoseconds now = 0ns; now < 10s; now += 30ms) starved.tick_done(now + 30ms, 8ms, 1.0);
  EXPECT_EQ(shared.total(), 0ns) << "one that nearly fills its time is late by itself";
}

TEST(Pace, KeepsAbsoluteDeadlines) {
  SharedSlip of_pace;
  Pace pace(10ms, of_pace);
  pace.start(100ms);
  EXPECT_EQ(pace.deadline(), Nanoseconds(100ms));
  pace.tick_done(107ms, 1ms, 1.0);
  EXPECT_EQ(pace.deadline(), Nanoseconds(110ms));
  pace.tick_done(120ms, 1ms, 1.0);  // to the nanosecond: not late, and the next is due
  EXPECT_EQ(pace.overruns(), 0);
  EXPECT_EQ(pace.deadline(), Nanoseconds(120ms));
  pace.tick_done(131ms, 1ms, 1.0);
  EXPECT_EQ(pace.overruns(), 1);
  EXPECT_EQ(pace.deadline(), Nanoseconds(130ms));
  EXPECT_EQ(pace.slipped(), Nanoseconds(0));
  EXPECT_NEAR(pace.tick_cpu_us(), 1000.0, 1e-9);
}

TEST(Pace, GivesUpWhatIsMoreThanTwoTicksLate) {
  SharedSlip of_pace;
  Pace pace(10ms, of_pace);
  pace.start(0ms);
  pace.tick_done(39ms, 1ms, 1.0);  // due: 10, 20, 30
  EXPECT_EQ(pace.slipped(), Nanoseconds(10ms));
  EXPECT_EQ(pace.deadline(), Nanoseconds(20ms));
  SharedSlip of_slow;
  Pace slow(10ms, of_slow);
  slow.start(0ms);
  for (int i = 1; i <= 200; ++i) slow.tick_done(i * 20ms, 20ms, 1.0);  // half as fast as it should be
  EXPECT_NEAR(slow.real_time_factor(), 0.5, 1e-6);
  EXPECT_EQ(slow.slipped() + 200 * 10ms, 4000ms - 10ms);  // one tick behind, all else given up
}

TEST(Pace, CountsWhatAStepStoppedShortOf) {
  SharedSlip of_pace;
  Pace pace(10ms, of_pace);
  pace.start(0ms);
  for (int i = 1; i <= 100; ++i) pace.tick_done(i * 10ms, 1ms, 0.25);
  EXPECT_EQ(pace.overruns(), 0);
  EXPECT_EQ(pace.slipped(), Nanoseconds(750ms));
  EXPECT_NEAR(pace.real_time_factor(), 0.25, 1e-9);
}

TEST(Pace, AtAnotherSpeedTicksAreAsFarApartAsItSays) {
  SharedSlip of_pace;
  Pace pace(10ms, of_pace);
  pace.start(100ms);
  pace.tick_done(101ms, 1ms, 1.0);
  ASSERT_EQ(pace.deadline(), Nanoseconds(110ms));
  pace.set_speed(0.25, 102ms);
  EXPECT_EQ(pace.deadline(), Nanoseconds(140ms));  // 40 ms after the one before it
  pace.tick_done(141ms, 1ms, 1.0);
  EXPECT_EQ(pace.deadline(), Nanoseconds(180ms));
  pace.set_speed(4.0, 150ms);  // it would have been due at 142.5 ms
  EXPECT_EQ(pace.deadline(), Nanoseconds(150ms));
  pace.tick_done(151ms, 1ms, 1.0);
  EXPECT_EQ(pace.deadline(), Nanoseconds(152500us));
  EXPECT_EQ(pace.overruns(), 0);
  EXPECT_EQ(pace.slipped(), Nanoseconds(0));
}

TEST(Pace, AFasterOneForgivesNoDelay) {
  SharedSlip of_pace;
  Pace pace(10ms, of_pace);
  pace.start(0ms);
  pace.tick_done(25ms, 1ms, 1.0);  // the next is due since 10 ms
  pace.set_speed(2.0, 25ms);
  EXPECT_EQ(pace.deadline(), Nanoseconds(10ms));
}

TEST(Pace, TellsWhatIsSimulatedHoweverSlow) {
  SharedSlip of_pace;
  Pace pace(10ms, of_pace);
  pace.start(0ms);
  pace.set_speed(0.5, 0ms);
  for (int i = 1; i <= 100; ++i) pace.tick_done(i * 20ms, 1ms, 1.0);
  EXPECT_NEAR(pace.real_time_factor(), 0.5, 1e-9);
  EXPECT_EQ(pace.overruns(), 0);
  pace.tick_done(2100ms, 1ms, 1.0);  // due: 2030, 2050, 2070, 2090; two of 10 ms simulated are given up
  EXPECT_EQ(pace.overruns(), 1);
  EXPECT_EQ(pace.slipped(), Nanoseconds(20ms));
}

TEST(Entropy, SeededRepeatsAndSystemDoesNot) {
  SeededEntropy a(4);
  SeededEntropy b(4);
  EXPECT_EQ(a.next(), b.next());
  EXPECT_EQ(a.next(), b.next());
  SystemEntropy system;
  std::set<std::uint64_t> seen;
  for (int i = 0; i < 100; ++i) seen.insert(system.next());
  EXPECT_EQ(seen.size(), 100U);
}

TEST(Metrics, HistogramPutsBoundsIntoTheirOwnClass) {
  DurationHistogram histogram;
  histogram.add(0.0);
  histogram.add(1.0e-5);
  histogram.add(1.1e-5);
  histogram.add(2.0);
  EXPECT_EQ(histogram.counts.front(), 2U);
  EXPECT_EQ(histogram.counts[1], 1U);
  EXPECT_EQ(histogram.counts.back(), 1U);
  EXPECT_EQ(histogram.total, 4U);
  EXPECT_NEAR(histogram.sum, 2.000021, 1e-12);
}

// Both disks keep the same promises.
void check_disk(Disk& disk, const std::string& folder) {
  const std::string path = folder + "file";
  EXPECT_EQ(disk.read_file(path, 10).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(disk.write_file(path, "first").ok());
  ASSERT_TRUE(disk.write_file(path, "second").ok());
  EXPECT_EQ(disk.read_file(path, 6).value(), "second");
  EXPECT_EQ(disk.read_file(path, 5).error().reason, "FILE_TOO_LARGE");
  Result<std::unique_ptr<AppendFile>> file = disk.create_file(path);
  ASSERT_TRUE(file.ok());
  ASSERT_TRUE((*file)->append("a").ok());
  ASSERT_TRUE((*file)->append(std::string("\0b", 2)).ok());
  ASSERT_TRUE((*file)->sync().ok());
  EXPECT_EQ(disk.read_file(path, 10).value(), std::string("a\0b", 3));
}

TEST(Disk, MemoryDisk) {
  MemoryDisk disk;
  check_disk(disk, "");
}

TEST(Disk, RealDisk) {
  const test::TemporaryFolder empty;
  const std::string folder = empty.path().string() + "/";
  RealDisk disk;
  check_disk(disk, folder);
  EXPECT_EQ(disk.write_file(folder + "no/such/folder", "x").error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(disk.create_file(folder).ok());
  EXPECT_FALSE(std::filesystem::exists(folder + "file.new"));

  std::filesystem::create_symlink(folder + "file", folder + "link");
  ASSERT_TRUE(disk.write_file(folder + "link", "through the link").ok());
  EXPECT_TRUE(std::filesystem::is_symlink(folder + "link"));
  EXPECT_EQ(disk.read_file(folder + "file", 100).value(), "through the link");
  std::filesystem::create_symlink("/dev/full", folder + "device");
  EXPECT_EQ(disk.write_file(folder + "device", "x").error().reason, "DISK_FULL");
  EXPECT_TRUE(std::filesystem::is_symlink(folder + "device"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST(Disk, AMemoryDiskRunsFullWithoutLosingWhatWasThere) {
  MemoryDisk disk(10);
  ASSERT_TRUE(disk.write_file("a", "12345").ok());
  EXPECT_EQ(disk.write_file("b", "123456").error().reason, "DISK_FULL");
  EXPECT_FALSE(disk.read_file("b", 10).ok());
  EXPECT_EQ(disk.write_file("a", "123456").error().reason, "DISK_FULL");
  EXPECT_EQ(disk.read_file("a", 10).value(), "12345");
  Result<std::unique_ptr<AppendFile>> file = disk.create_file("c");
  ASSERT_TRUE(file.ok());
  EXPECT_TRUE((*file)->append("12345").ok());
  EXPECT_EQ((*file)->append("1").error().reason, "DISK_FULL");
  disk.set_capacity(11);
  EXPECT_TRUE((*file)->append("6").ok());
  EXPECT_EQ(disk.read_file("c", 10).value(), "123456");
}

// Limits how long files may become, in this process, for as long as it lives.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    EXPECT_EQ(::getrlimit(RLIMIT_FSIZE, &before_), 0);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    before_handler_ = std::signal(SIGXFSZ, SIG_IGN);
    EXPECT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, before_handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*before_handler_)(int) = nullptr;
};

TEST(Disk, AFailedAppendLeavesNoPart) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "file";
  RealDisk disk;
  Result<std::unique_ptr<AppendFile>> file = disk.create_file(path);
  ASSERT_TRUE(file.ok());
  ASSERT_TRUE((*file)->append("12345678").ok());
  {
    const FileSizeLimit limit(10);
    EXPECT_EQ((*file)->append("abcd").error().reason, "FILE_TOO_LARGE");
    EXPECT_EQ(disk.read_file(path, 100).value(), "12345678");
    EXPECT_TRUE((*file)->append("9").ok());
  }
  EXPECT_TRUE((*file)->append("abcd").ok());
  EXPECT_EQ(disk.read_file(path, 100).value(), "123456789abcd");
}

}  // namespace
}  // namespace kerf::host
