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

// The sheets of a run: hung from their top corners, which move to and fro, so that they never come to rest; or, of a
// still plan, lying flat without gravity, so that they fall asleep.
class SheetSet {
 public:
  static constexpr std::chrono::seconds kPatience{30};
  // "making sheets" and "taking down", and how much of that is done, 0..1; some times a second.
  using Tell = std::function<void(const char* stage, double share)>;

  // Creates them until one is refused for want of capacity. What of a still plan is refused as the server is
  // overloaded is asked for again, for kPatience: those that are there soon sleep.
  SheetSet(const Plan& plan, client::Client& client, Waiter& waiter, Tell tell);
  ~SheetSet();  // deletes them
  SheetSet(const SheetSet&) = delete;
  SheetSet& operator=(const SheetSet&) = delete;

  // What ended the run before it began: anything but a want of capacity.
  [[nodiscard]] const grpc::Status& failure() const { return failure_; }
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }  // "sheets/load-0" ...
  [[nodiscard]] const std::map<std::string, std::int64_t>& refusals() const { return refusals_; }  // by reason
  [[nodiscard]] const std::string& first_refusal() const { return first_refusal_; }                // the server's words
  [[nodiscard]] const std::string& integrator() const { return integrator_; }                      // of the first sheet

 private:
  // Of one CreateSheet; whether to go on.
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
