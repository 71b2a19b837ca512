#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include <grpcpp/support/status.h>

#include "client/cpp/client.h"
#include "client/load/plan.h"
#include "client/load/schedule.h"

namespace kerf::load {

// Owns the sheets of a run. They hang from their top corners, which move to and fro, so that they never come to rest.
// With a still plan they lie flat without gravity and fall asleep. They are paused if the plan has stages of sheets.
class SheetSet {
 public:
  static constexpr std::chrono::seconds kPatience{30};
  // Reports "creating sheets" and "deleting sheets" with the share done, 0..1; some times a second.
  using Tell = std::function<void(const char* stage, double share)>;

  // Creates the sheets until one is refused for lack of capacity. With a still plan, a sheet refused because of
  // overload is retried for kPatience, because the existing sheets soon sleep.
  SheetSet(const Plan& plan, client::Client& client, Waiter& waiter, Tell tell);
  ~SheetSet();  // Deletes the sheets.
  SheetSet(const SheetSet&) = delete;
  SheetSet& operator=(const SheetSet&) = delete;

  // Returns the error that ended the run before it began: anything except a lack of capacity.
  [[nodiscard]] const grpc::Status& failure() const { return failure_; }
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }  // "sheets/load-0" ...
  [[nodiscard]] const std::map<std::string, std::int64_t>& refusals() const { return refusals_; }  // By reason.
  [[nodiscard]] const std::string& first_refusal() const { return first_refusal_; }  // The server's words.
  [[nodiscard]] const std::string& integrator() const { return integrator_; }        // Used by the first sheet.

 private:
  // Records the result of one CreateSheet; returns true if more are to follow.
  bool take(const grpc::Status& status, const v1::Sheet& sheet);

  const Plan& plan_;
  client::Client& client_;
  const Tell tell_;
  std::mutex mutex_;
  std::vector<std::string> names_;
  std::map<std::string, std::int64_t> refusals_;
  std::string first_refusal_;
  std::string integrator_;
  grpc::Status failure_;
  bool full_ = false;
};

}  // namespace kerf::load
