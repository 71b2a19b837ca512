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

// Remembers requests by request_id. A request sent again, because its answer was lost, has no further effect and gets
// the same answer. Only successes are remembered: a refused request may be tried again. The least recently used ids are
// forgotten beyond `capacity` ids or `max_bytes`. Thread-safe.
class RequestLog {
 public:
  // Serialised response or the refusal.
  using Outcome = Result<std::string>;
  using Waiter = std::function<void(const Outcome&)>;

  // `max_bytes`: of keys and responses together.
  RequestLog(std::size_t capacity, std::size_t max_bytes) : capacity_(capacity), max_bytes_(max_bytes) {}

  // Registers a caller. If it is the first with this key, returns a token; the caller must then do the request and call
  // finish(). The token is triggered once all callers with this key have left, as each one's `caller` signals.
  //
  // For later callers, returns nothing and calls `waiter` with the outcome of the first request, at once or once it is
  // known. `waiter` gets kAlreadyExists REQUEST_ID_REUSED instead if `body_hash`, that of hash_of(), differs from that
  // of the first.
  std::optional<std::stop_token> begin(const std::string& key, std::uint64_t body_hash, Waiter waiter,
                                       const std::stop_token& caller = {});

  void finish(const std::string& key, const Outcome& outcome);
  // Adds a request that was done before the server started, with its answer; an older one than those there already.
  void remember(std::string key, std::uint64_t body_hash, std::string response);

  // Returns the hash by which bodies are compared.
  static std::uint64_t hash_of(std::string_view body);

 private:
  struct Entry {
    std::string key;
    std::uint64_t body_hash = 0;
    bool done = false;
    std::string response;              // Set once done.
    std::vector<Waiter> waiters;       // Used until done.
    std::unique_ptr<Callers> callers;  // until done

    [[nodiscard]] std::size_t bytes() const { return key.size() + response.size(); }
  };
  using Entries = std::list<Entry>;

  // These need mutex_ held.
  void forget_surplus();
  Entries::iterator forget(Entries::iterator entry);

  const std::size_t capacity_;
  const std::size_t max_bytes_;
  std::mutex mutex_;
  Entries entries_;  // Most recently used first.
  std::unordered_map<std::string, Entries::iterator> by_key_;
  std::size_t bytes_ = 0;  // Summed over all entries.
};

}  // namespace kerf::api
