#include "server/service/api/request_log.h"

#include <iterator>
#include <span>
#include <utility>

#include "server/base/check.h"
#include "server/base/state_hash.h"

namespace kerf::api {

std::uint64_t RequestLog::hash_of(std::string_view body) {
  StateHash hash;
  hash.add_span(std::span<const char>(body));
  return hash.value();
}

void RequestLog::remember(std::string key, std::uint64_t body_hash, std::string response) {
  const std::lock_guard lock(mutex_);
  if (by_key_.contains(key)) return;
  entries_.push_back({std::move(key), body_hash, true, std::move(response), {}, {}});
  by_key_[entries_.back().key] = std::prev(entries_.end());
  bytes_ += entries_.back().bytes();
  forget_surplus();
}

std::optional<std::stop_token> RequestLog::begin(const std::string& key, std::uint64_t body_hash, Waiter waiter,
                                                 const std::stop_token& caller) {
  Outcome known = std::string();
  {
    const std::lock_guard lock(mutex_);
    const auto found = by_key_.find(key);
    if (found == by_key_.end()) {
      entries_.push_front({key, body_hash, false, {}, {}, std::make_unique<Callers>()});
      by_key_[key] = entries_.begin();
      bytes_ += key.size();
      Callers& callers = *entries_.front().callers;
      callers.join(caller);
      return callers.all_left();
    }
    Entry& entry = *found->second;
    entries_.splice(entries_.begin(), entries_, found->second);
    if (entry.body_hash != body_hash) {
      known = already_exists("REQUEST_ID_REUSED",
                             "this request_id was used for another request; choose a new one for each request",
                             "request_id");
    } else if (!entry.done) {
      entry.waiters.push_back(std::move(waiter));
      entry.callers->join(caller);
      return std::nullopt;
    } else {
      known = entry.response;
    }
  }
  waiter(known);
  return std::nullopt;
}

void RequestLog::finish(const std::string& key, const Outcome& outcome) {
  std::vector<Waiter> waiters;
  {
    const std::lock_guard lock(mutex_);
    const auto found = by_key_.find(key);
    KERF_CHECK(found != by_key_.end() && !found->second->done, "a request is finished that was not begun");
    waiters.swap(found->second->waiters);
    found->second->callers.reset();
    if (outcome.ok()) {
      found->second->done = true;
      found->second->response = outcome.value();
      bytes_ += outcome.value().size();
      forget_surplus();
    } else {
      forget(found->second);
    }
  }
  for (const Waiter& waiter : waiters) waiter(outcome);
}

// Keeps requests in progress, which will be finished.
void RequestLog::forget_surplus() {
  const auto too_much = [this] { return entries_.size() > capacity_ || bytes_ > max_bytes_; };
  for (auto entry = entries_.end(); too_much() && entry != entries_.begin();) {
    --entry;
    if (entry->done) entry = forget(entry);
  }
}

RequestLog::Entries::iterator RequestLog::forget(Entries::iterator entry) {
  bytes_ -= entry->bytes();
  by_key_.erase(entry->key);
  return entries_.erase(entry);
}

}  // namespace kerf::api
