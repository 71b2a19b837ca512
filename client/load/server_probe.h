#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/cpp/client.h"
#include "client/load/plan.h"
#include "client/load/schedule.h"
#include "server/base/process_usage.h"

namespace kerf::load {

// One sheet as the server lists it.
struct SheetCounts {
  std::int64_t tick = 0;
  std::int64_t overruns = 0;
  double slipped_s = 0.0;
  std::string run_state;  // "RUNNING", "SLEEPING" ...
};

// What the server and this program had done by some time.
struct Probe {
  Nanoseconds time{0};
  double load = 0.0;       // see ServerInfo.load
  std::int64_t ticks = 0;  // of the run's sheets, sums
  std::int64_t overruns = 0;
  double slipped_s = 0.0;
  std::optional<ProcessUsage> server;
  ProcessUsage client;
  std::optional<double> frames_encoded;  // of all sheets, from the metrics page
};

// Puts the sums over `sheets` into `probe`.
void add_sums(const std::map<std::string, SheetCounts>& sheets, Probe& probe);

// Asks the server how it does.
class ServerProbe {
 public:
  ServerProbe(const Plan& plan, client::Client& client) : plan_(plan), client_(client) {}

  // By name, of the run's sheets. Of a call that fails nothing, and failure() says why.
  std::map<std::string, SheetCounts> sheets();
  // Pages that the last sheets() took, and how long they took together.
  [[nodiscard]] std::int32_t pages() const { return pages_; }
  [[nodiscard]] Nanoseconds listing_took() const { return listing_took_; }

  // All but the sums over sheets.
  Probe probe();

  [[nodiscard]] const std::optional<grpc::Status>& failure() const { return failure_; }

 private:
  const Plan& plan_;
  client::Client& client_;
  std::int32_t pages_ = 0;
  Nanoseconds listing_took_{0};
  std::optional<grpc::Status> failure_;
};

// The body of http://`address``target`; nothing where it is not answered with 200 within some seconds.
std::optional<std::string> http_get(const std::string& address, const std::string& target);

}  // namespace kerf::load
