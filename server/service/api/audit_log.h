#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

#include "server/base/result.h"
#include "server/base/token_bucket.h"
#include "server/service/auth/grant.h"
#include "server/service/host/clock.h"

namespace kerf::api {

// Writes a line for each call that changes something, and for each token that is refused: a kerf.v1.AuditEntry as JSON.
// Refusals beyond kRefusalsPerMinute are left out and counted, so that a stranger cannot fill the disk. Thread-safe.
class AuditLog {
 public:
  static constexpr double kRefusalsPerMinute = 120.0;

  // Appends a line, which ends with "\n", whole or not at all. Returns false if that fails.
  using Append = std::function<bool(std::string_view line)>;
  // `clock` must outlive this.
  AuditLog(Append append, host::Clock& clock);

  struct Entry {
    auth::Caller caller;
    std::string call;
    std::string sheet;       // id; empty: none
    std::string request_id;  // empty: none
  };
  // `outcome`: whether the call was done.
  void add(const Entry& entry, const Status& outcome);

 private:
  const Append append_;
  host::Clock& clock_;
  std::mutex mutex_;
  TokenBucket refusals_;       // guarded by mutex_
  std::int64_t left_out_ = 0;  // guarded by mutex_
};

}  // namespace kerf::api
