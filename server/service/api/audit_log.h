#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "server/base/result.h"
#include "server/base/token_bucket.h"
#include "server/service/auth/grant.h"
#include "server/service/host/clock.h"

namespace kerf::api {

// Writes a line for each call that changes something, and for each token that is refused: a kerf.v1.AuditEntry as JSON.
// Writes kMaxRefusals refusals of each token at once, and as many a minute; all unknown tokens count as one. Counts the
// others, so that no caller fills the disk or hides what others do. Cuts long names. Thread-safe.
class AuditLog {
 public:
  static constexpr double kMaxRefusals = 60.0;
  static constexpr std::size_t kLongestName = 64;  // Bytes of a sheet's id and of a request_id.

  // Appends a line, which ends with "\n", whole or not at all. Returns false if that fails.
  using Append = std::function<bool(std::string_view line)>;
  // `clock` must outlive this.
  AuditLog(Append append, host::Clock& clock) : append_(std::move(append)), clock_(clock) {}

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
  std::map<std::string, TokenBucket> refusals_;  // by the id of the token; guarded by mutex_
  std::int64_t left_out_ = 0;                    // guarded by mutex_
};

}  // namespace kerf::api
