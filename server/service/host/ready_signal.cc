#include "server/service/host/ready_signal.h"

#include <algorithm>
#include <utility>

namespace kerf::api {

void ReadySignal::set(std::function<void()> ready) {
  const auto self = std::this_thread::get_id();
  std::unique_lock lock(mutex_);
  ready_ = ready ? std::make_shared<const std::function<void()>>(std::move(ready)) : nullptr;
  returned_.wait(lock, [&] {
    return std::all_of(callers_.begin(), callers_.end(), [&](std::thread::id each) { return each == self; });
  });
}

void ReadySignal::raise() {
  const auto self = std::this_thread::get_id();
  std::shared_ptr<const std::function<void()>> ready;
  {
    const std::lock_guard lock(mutex_);
    if (!ready_) return;
    ready = ready_;
    callers_.push_back(self);
  }
  (*ready)();
  ready.reset();  // Releases the captured objects before set() resumes.
  const std::lock_guard lock(mutex_);
  callers_.erase(std::find(callers_.begin(), callers_.end(), self));
  returned_.notify_all();
}

}  // namespace kerf::api
