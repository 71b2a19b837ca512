#include "server/service/host/wake_callback.h"

#include <algorithm>
#include <utility>

namespace kerf::host {

void WakeCallback::set(std::function<void()> wake) {
  const auto self = std::this_thread::get_id();
  std::unique_lock lock(mutex_);
  wake_ = wake ? std::make_shared<const std::function<void()>>(std::move(wake)) : nullptr;
  returned_.wait(lock, [&] {
    return std::all_of(callers_.begin(), callers_.end(), [&](std::thread::id each) { return each == self; });
  });
}

void WakeCallback::call() {
  const auto self = std::this_thread::get_id();
  std::shared_ptr<const std::function<void()>> wake;
  {
    const std::lock_guard lock(mutex_);
    if (!wake_) return;
    wake = wake_;
    callers_.push_back(self);
  }
  (*wake)();
  wake.reset();  // Releases the captured objects before set() resumes.
  const std::lock_guard lock(mutex_);
  callers_.erase(std::find(callers_.begin(), callers_.end(), self));
  returned_.notify_all();
}

}  // namespace kerf::host
