#include <condition_variable>
#include <functional>
#include <map>

#include "tests/host/fixture.h"

namespace kerf::host {
namespace {

constexpr int kSheets = 8;
constexpr int kTicks = 40;

scene::SheetConfig scene(int i) {
  scene::SheetConfig config = i % 2 == 0 ? scenes::hanging_with_three_cuts(8 + i) : scenes::draped_over_sphere(7 + i);
  config.commands.push_back({12, scenes::line_cut({0.1 * i, -0.1}, {0.5, 1.1})});
  return config;
}

using Hashes = std::map<std::string, std::vector<std::uint64_t>>;

// The hash after every tick of eight sheets on `workers` threads, a heavy one beside them if asked for.
Hashes hashes_with(std::int32_t workers, bool heavy) {
  std::map<std::string, std::shared_ptr<sheet::Recorder>> recorders;
  for (int i = 0; i < kSheets; ++i) recorders["s" + std::to_string(i)] = std::make_shared<sheet::Recorder>();
  test::ManualClock clock;
  SeededEntropy entropy(1);
  HostOptions options;
  options.workers = workers;
  options.make_recording = [&](const std::string& id) -> std::shared_ptr<sheet::RecordingSink> {
    const auto found = recorders.find(id);
    return found == recorders.end() ? nullptr : found->second;
  };
  Host host(options, clock, entropy);
  const Callback<SheetStatus> ignore = [](const Result<SheetStatus>& status) { EXPECT_TRUE(status.ok()); };
  for (const auto& [id, recorder] : recorders) host.create_sheet(id, scene(id[1] - '0'), true, ignore);
  if (heavy) host.create_sheet("heavy", scenes::hanging_with_three_cuts(40), true, ignore);
  host.wait_idle();
  for (const auto& [id, recorder] : recorders) host.step(id, kTicks, ignore);
  if (heavy) host.step("heavy", 10, ignore);
  // Commands from outside while everything runs; they land where they land, so only on the heavy one.
  if (heavy) host.submit("heavy", scenes::circle_cut({0.5, 0.5}, 0.2), [](const Result<CommandResult>&) {});
  host.wait_idle();
  Hashes hashes;
  for (const auto& [id, recorder] : recorders) {
    for (const sheet::RecordedTick& entry : recorder->recording().entries) hashes[id].push_back(entry.state_hash);
    EXPECT_EQ(hashes[id].size(), static_cast<std::size_t>(kTicks)) << id;
  }
  return hashes;
}

TEST(HostDeterminism, EightSheetsHaveEqualHashesForAnyNumberOfWorkers) {
  const Hashes alone = hashes_with(1, false);
  for (const std::int32_t workers : {2, 4, 7}) EXPECT_EQ(hashes_with(workers, false), alone) << workers << " workers";
}

TEST(HostDeterminism, AHeavySheetDoesNotMoveTheOthers) {
  EXPECT_EQ(hashes_with(3, true), hashes_with(1, false));
}

// The same on the real clock, with the timers' own thread; counts and hashes, no times.
TEST(HostDeterminism, RealTimeGivesTheHashesOfSimulatedTime) {
  RealClock clock;
  SeededEntropy entropy(1);
  const auto recorder = std::make_shared<sheet::Recorder>();
  HostOptions options;
  options.workers = 3;
  options.make_recording = [&](const std::string& id) { return id == "s0" ? recorder : nullptr; };
  Host host(options, clock, entropy);
  scene::SheetConfig config = scene(0);
  config.tick_rate_hz = 1000.0;
  std::mutex mutex;
  std::condition_variable reached;
  std::int64_t tick = 0;
  class TickWatch : public sheet::SnapshotSink {
   public:
    explicit TickWatch(std::function<void(std::int64_t)> on_tick) : on_tick_(std::move(on_tick)) {}
    [[nodiscard]] bool wants_snapshot() const override { return true; }
    void publish(std::shared_ptr<const sheet::Snapshot> snapshot) override { on_tick_(snapshot->tick); }
    void ended(sheet::SinkEnd /*reason*/) override {}

   private:
    std::function<void(std::int64_t)> on_tick_;
  };
  const auto watch = std::make_shared<TickWatch>([&](std::int64_t at) {
    const std::lock_guard lock(mutex);
    tick = at;
    reached.notify_all();
  });
  host.create_sheet("s0", config, false, [&](const Result<SheetStatus>& created) {
    EXPECT_TRUE(created.ok());
    host.add_sink("s0", watch, [](const Result<Nothing>&) {});
  });
  host.create_sheet("s1", scene(1), false, [](const Result<SheetStatus>&) {});
  {
    std::unique_lock lock(mutex);
    reached.wait(lock, [&] { return tick >= 60; });
  }
  host.stop();
  sheet::Sheet sheet = sheet::Sheet::create(config).value();
  for (const sheet::RecordedTick& entry : recorder->recording().entries) {
    sheet.step({});
    ASSERT_EQ(entry.state_hash, sheet.state_hash()) << "tick " << entry.tick;
  }
  EXPECT_GE(sheet.tick(), 60);
}

}  // namespace
}  // namespace kerf::host
