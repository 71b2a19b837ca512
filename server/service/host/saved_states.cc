#include "server/service/host/saved_states.h"

#include <algorithm>
#include <utility>

namespace kerf::host {

namespace {

auto find_state(auto& states, const std::string& id) {
  return std::find_if(states.begin(), states.end(), [&](const auto& each) { return each->status.id == id; });
}

Error no_state(const std::string& sheet, const std::string& id) {
  return not_found("STATE_NOT_FOUND", "the sheet \"" + sheet + "\" has no saved state \"" + id + "\"");
}

}  // namespace

const SavedStates::OfSheet& SavedStates::of(const std::string& sheet) const {
  static const OfSheet none;
  const auto found = states_.find(sheet);
  return found == states_.end() ? none : found->second;
}

Status SavedStates::check_locked(const OfSheet& states, const std::string& id, bool overwrite) const {
  const bool exists = find_state(states, id) != states.end();
  if (exists && !overwrite) {
    return already_exists("STATE_EXISTS",
                          "the sheet has a saved state \"" + id + "\" already; overwrite it, or choose another name");
  }
  if (!exists && states.size() >= static_cast<std::size_t>(max_per_sheet_)) {
    return resource_exhausted("TOO_MANY_STATES", "the sheet has " + std::to_string(max_per_sheet_) +
                                                     " saved states, its limit; delete one, or overwrite one");
  }
  return Nothing{};
}

Status SavedStates::check(const std::string& sheet, const std::string& id, bool overwrite) const {
  const std::lock_guard lock(mutex_);
  return check_locked(of(sheet), id, overwrite);
}

std::int64_t SavedStates::bytes_locked(const std::string& tenant) const {
  const std::string prefix = tenant + "-";
  std::int64_t bytes = 0;
  for (auto at = states_.lower_bound(prefix); at != states_.end() && at->first.starts_with(prefix); ++at) {
    for (const auto& state : at->second) bytes += state->status.num_bytes;
  }
  return bytes;
}

std::int64_t SavedStates::bytes_of(const std::string& tenant) const {
  const std::lock_guard lock(mutex_);
  return bytes_locked(tenant);
}

Status SavedStates::add(const std::string& sheet, std::shared_ptr<const SavedState> state, bool overwrite,
                        const std::string& tenant, const CheckSum& check_sum) {
  const std::lock_guard lock(mutex_);
  KERF_TRY(check_locked(of(sheet), state->status.id, overwrite));
  OfSheet& states = states_[sheet];
  states.reserve(states.size() + 1);
  const auto old = find_state(states, state->status.id);
  const std::int64_t freed = old == states.end() ? 0 : (*old)->status.num_bytes;
  const std::int64_t bytes = bytes_ - freed + state->status.num_bytes;
  if (bytes > max_bytes_) {
    return resource_exhausted("STATES_TOO_LARGE", "this state takes " + std::to_string(state->status.num_bytes) +
                                                      " bytes; the saved states of this server may take " +
                                                      std::to_string(max_bytes_) + " together: delete some");
  }
  if (!tenant.empty()) KERF_TRY(check_sum(bytes_locked(tenant) - freed + state->status.num_bytes));
  bytes_ = bytes;
  if (old != states.end()) states.erase(old);
  states.push_back(std::move(state));
  return Nothing{};
}

Result<std::shared_ptr<const SavedState>> SavedStates::find(const std::string& sheet, const std::string& id) const {
  const std::lock_guard lock(mutex_);
  const OfSheet& states = of(sheet);
  const auto found = find_state(states, id);
  if (found == states.end()) return no_state(sheet, id);
  return *found;
}

std::vector<SavedStateStatus> SavedStates::list(const std::string& sheet) const {
  std::vector<SavedStateStatus> listed;
  const std::lock_guard lock(mutex_);
  for (const auto& state : of(sheet)) listed.push_back(state->status);
  return listed;
}

Status SavedStates::remove(const std::string& sheet, const std::string& id) {
  std::shared_ptr<const SavedState> removed;  // Destroyed after the lock is given back.
  const std::lock_guard lock(mutex_);
  const auto states = states_.find(sheet);
  if (states == states_.end()) return no_state(sheet, id);
  const auto found = find_state(states->second, id);
  if (found == states->second.end()) return no_state(sheet, id);
  removed = std::move(*found);
  bytes_ -= removed->status.num_bytes;
  states->second.erase(found);
  return Nothing{};
}

void SavedStates::forget(const std::string& sheet) {
  const std::lock_guard lock(mutex_);
  for (const auto& state : of(sheet)) bytes_ -= state->status.num_bytes;
  states_.erase(sheet);
}

}  // namespace kerf::host
