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

// Holds the server's counts for one sheet.
struct SheetCounts {
  std::int64_t tick = 0;
  std::int64_t overruns = 0;
  double slipped_s = 0.0;
  std::string run_state;  // "RUNNING", "SLEEPING" ...
};

// Holds the totals of the server and of this program at some time.
struct Probe {
  Nanoseconds time{0};
  double load = 0.0;       // See ServerInfo.load.
  std::int64_t ticks = 0;  // Sum over the run's sheets, as are the next two.
  std::int64_t overruns = 0;
  double slipped_s = 0.0;
  std::optional<ProcessUsage> server;
  ProcessUsage client;
  std::optional<double> frames_encoded;  // Number since the server started, all sheets; empty without a metrics page.
};

// Stores the sums over `sheets` in `probe`.
void add_sums(const std::map<std::string, SheetCounts>& sheets, Probe& probe);

// Reads the server's counters.
class ServerProbe {
 public:
  ServerProbe(const Plan& plan, client::Client& client) : plan_(plan), client_(client) {}

  // Returns the counts of the run's sheets by name. If the call fails it returns none, and failure() has the error.
  std::map<std::string, SheetCounts> sheets();
  // Return the number of pages of the last sheets(), and their total time.
  [[nodiscard]] std::int32_t pages() const { return pages_; }
  [[nodiscard]] Nanoseconds listing_took() const { return listing_took_; }

  // Reads everything except the sums over sheets.
  Probe probe();

  [[nodiscard]] const std::optional<grpc::Status>& failure() const { return failure_; }

 private:
  const Plan& plan_;
  client::Client& client_;
  std::int32_t pages_ = 0;
  Nanoseconds listing_took_{0};
  std::optional<grpc::Status> failure_;
};

// Returns the body of http://`address``target`, or https:// if the secrets say so, asked for with their token. Returns
// nothing without an answer of 200 within some seconds.
std::optional<std::string> http_get(const std::string& address, const std::string& target,
                                    const client::Secrets& secrets);

}  // namespace kerf::load
