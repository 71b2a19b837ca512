#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "client/cpp/client.h"
#include "client/load/cut_tracker.h"
#include "client/load/plan.h"
#include "client/load/recorder.h"
#include "client/load/schedule.h"
#include "server/base/random.h"

namespace kerf::load {

// Cuts sheets in turn at times fixed beforehand, without waiting for the answers to earlier cuts. Cuts are at most 0.1
// m long, at places drawn from the plan's seed.
class Cutter {
 public:
  static constexpr std::int32_t kMostUnderWay = 10'000;  // Calls awaiting an answer; more are not made: errors.

  // Cuts the first `count` sheets between recorder.begin() and recorder.end(); none while it is 0. All arguments must
  // outlive the Cutter.
  Cutter(const Plan& plan, const std::vector<std::string>& sheets, const std::atomic<std::int32_t>& count,
         client::Client& client, Recorder& recorder, CutTracker& tracker, Waiter& waiter);
  ~Cutter();  // Waits for the end and for all answers.
  Cutter(const Cutter&) = delete;
  Cutter& operator=(const Cutter&) = delete;

 private:
  struct Call;

  void send(std::int64_t k, Nanoseconds intended);
  void answered(const Call& call, const grpc::Status& status);
  void undo(std::size_t sheet);
  bool begin_call();
  void end_call();

  const Plan& plan_;
  const std::vector<std::string>& sheets_;
  const std::atomic<std::int32_t>& count_;
  client::Client& client_;
  Recorder& recorder_;
  CutTracker& tracker_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::int32_t under_way_ = 0;  // Guarded by mutex_.
  SeededRandom random_;
  std::thread thread_;
};

}  // namespace kerf::load
