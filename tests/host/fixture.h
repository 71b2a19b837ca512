#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/service/host/host.h"
#include "tests/support/manual_clock.h"
#include "tests/support/scenes.h"

namespace kerf::host {

using namespace std::chrono_literals;

// The answers that a callback of type Callback<T> was given, in order.
template <typename T>
class Answers {
 public:
  Callback<T> callback() {
    return [state = state_](Result<T> result) {
      const std::lock_guard lock(state->mutex);
      state->results.push_back(std::move(result));
    };
  }
  [[nodiscard]] std::size_t count() const {
    const std::lock_guard lock(state_->mutex);
    return state_->results.size();
  }
  [[nodiscard]] Result<T> at(std::size_t i) const {
    const std::lock_guard lock(state_->mutex);
    return state_->results.at(i);
  }
  [[nodiscard]] std::string reason(std::size_t i) const {
    const Result<T> result = at(i);
    return result.ok() ? "done" : result.error().reason;
  }

 private:
  struct State {
    std::mutex mutex;
    std::vector<Result<T>> results;
  };
  std::shared_ptr<State> state_ = std::make_shared<State>();
};

// Keeps what it is given; a switch says whether it wants more.
class RecordingSnapshots : public sheet::SnapshotSink {
 public:
  [[nodiscard]] bool wants_snapshot() const override {
    const std::lock_guard lock(mutex_);
    return wants_;
  }
  void publish(std::shared_ptr<const sheet::Snapshot> snapshot) override {
    const std::lock_guard lock(mutex_);
    snapshots_.push_back(std::move(snapshot));
  }
  void ended(sheet::SinkEnd reason) override {
    const std::lock_guard lock(mutex_);
    ends_.push_back(reason);
  }

  void want(bool wants) {
    const std::lock_guard lock(mutex_);
    wants_ = wants;
  }
  [[nodiscard]] std::vector<std::shared_ptr<const sheet::Snapshot>> snapshots() const {
    const std::lock_guard lock(mutex_);
    return snapshots_;
  }
  [[nodiscard]] std::vector<sheet::SinkEnd> ends() const {
    const std::lock_guard lock(mutex_);
    return ends_;
  }

 private:
  mutable std::mutex mutex_;
  bool wants_ = true;
  std::vector<std::shared_ptr<const sheet::Snapshot>> snapshots_;
  std::vector<sheet::SinkEnd> ends_;
};

// A host on a clock that the test moves. Ticks of 1/50 s, so that times are whole milliseconds.
class HostTest : public testing::Test {
 protected:
  static constexpr Nanoseconds kTick = 20ms;

  explicit HostTest(HostOptions options = {}) : host_(std::make_unique<Host>(std::move(options), clock_, entropy_)) {}

  static scene::SheetConfig at_50_hz(scene::SheetConfig config) {
    config.tick_rate_hz = 50.0;
    return config;
  }
  static scene::SheetConfig small_sheet() { return at_50_hz(scenes::hanging(5)); }

  SheetStatus create(const std::string& id, scene::SheetConfig config, bool paused = false) {
    Answers<SheetStatus> answers;
    host_->create_sheet(id, std::move(config), paused, answers.callback());
    host_->wait_idle();
    return answers.at(0).value();
  }

  // Lets simulated time pass as on a machine that is never late: every timer fires at its deadline, and what it starts
  // ends before the next.
  void run_for(Nanoseconds duration) {
    const Nanoseconds end = clock_.now() + duration;
    host_->wait_idle();
    while (true) {
      const std::optional<Nanoseconds> next = clock_.next_deadline();
      if (!next || *next > end) break;
      clock_.move_to(std::max(*next, clock_.now()));
      host_->wait_idle();
    }
    clock_.move_to(std::max(end, clock_.now()));  // what runs may have moved it, too
    host_->wait_idle();
  }

  // A machine that did nothing for a while, then caught up.
  void stall_for(Nanoseconds duration) {
    host_->wait_idle();
    clock_.move_to(clock_.now() + duration);
    host_->wait_idle();
  }

  SheetStatus status(const std::string& id) {
    Answers<SheetStatus> answers;
    host_->status(id, answers.callback());
    host_->wait_idle();
    return answers.at(0).value();
  }

  Result<CommandResult> submit(const std::string& id, scene::Command command) {
    Answers<CommandResult> answers;
    host_->submit(id, std::move(command), answers.callback());
    run_for(2 * kTick);
    return answers.at(0);
  }

  test::ManualClock clock_;
  SeededEntropy entropy_{1};
  std::unique_ptr<Host> host_;
};

}  // namespace kerf::host
