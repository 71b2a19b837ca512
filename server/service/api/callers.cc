#include "server/service/api/callers.h"

namespace kerf::api {

void Callers::join(const std::stop_token& caller) {
  ++num_present_;
  const std::lock_guard lock(mutex_);
  leavings_.emplace_back(caller, [this] { leave(); });  // Calls leave() here if the caller has left already.
}

// Takes no mutex, because join() may be running on this thread.
void Callers::leave() {
  if (--num_present_ == 0) all_left_.request_stop();
}

}  // namespace kerf::api
