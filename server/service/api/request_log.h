#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "server/base/result.h"
#include "server/service/api/callers.h"

namespace kerf::api {

// Requests by their request_id, so that one that is sent again (the first answer was lost on its way) does nothing more
// and gets the same answer. Only successes are remembered: a refused request may be tried again. Of the ids beyond
// `capacity`, and of those that take more than `max_bytes` together, the ones used longest ago are forgotten.
// Thread-safe.
class RequestLog {
 public:
  // A serialised response or the refusal.
  using Outcome = Result<std::string>;
  using Waiter = std::function<void(const Outcome&)>;

  // `max_bytes`: of keys and responses.
  RequestLog(std::size_t capacity, std::size_t max_bytes) : capacity_(capacity), max_bytes_(max_bytes) {}

  // A token: the caller is the first with this key; it does the request and then calls finish(). The token asks for a
  // stop once the first and all that wait for it have left, as `caller` says of each. Nothing: `waiter` is called
  // instead, with what the first got, at once or when that is known; or with kAlreadyExists REQUEST_ID_REUSED if the
  // bodies differ (compared by a 64-bit hash).
  std::optional<std::stop_token> begin(const std::string& key, std::string_view body, Waiter waiter,
                                       const std::stop_token& caller = {});

  void finish(const std::string& key, const Outcome& outcome);

 private:
  struct Entry {
    std::string key;
    std::uint64_t body_hash = 0;
    bool done = false;
    std::string response;              // once done
    std::vector<Waiter> waiters;       // until done
    std::unique_ptr<Callers> callers;  // until done

    [[nodiscard]] std::size_t bytes() const { return key.size() + response.size(); }
  };
  using Entries = std::list<Entry>;

  // mutex_ held.
  void forget_surplus();
  Entries::iterator forget(Entries::iterator entry);

  const std::size_t capacity_;
  const std::size_t max_bytes_;
  std::mutex mutex_;
  Entries entries_;  // used last first
  std::unordered_map<std::string, Entries::iterator> by_key_;
  std::size_t bytes_ = 0;  // of all entries
};

}  // namespace kerf::api
