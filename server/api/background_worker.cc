#include "server/api/background_worker.h"

#include <utility>

namespace kerf::api {

BackgroundWorker::BackgroundWorker(std::size_t max_waiting) : max_waiting_(max_waiting), thread_([this] { run(); }) {}

BackgroundWorker::~BackgroundWorker() {
  stop();
}

BackgroundWorker::Outcome BackgroundWorker::submit(std::function<void()> work, std::function<void()> refuse) {
  {
    const std::lock_guard lock(mutex_);
    if (stopped_) return Outcome::kStopped;
    const std::size_t room = max_waiting_ + (busy_ ? 0 : 1);
    if (waiting_.size() >= room) return Outcome::kFull;
    waiting_.push_back({std::move(work), std::move(refuse)});
  }
  changed_.notify_one();
  return Outcome::kTaken;
}

void BackgroundWorker::close() {
  std::deque<Task> refused;
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    refused.swap(waiting_);
  }
  changed_.notify_all();
  for (const Task& task : refused) task.refuse();
}

void BackgroundWorker::stop() {
  close();
  if (thread_.joinable()) thread_.join();
}

void BackgroundWorker::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stopped_ || !waiting_.empty(); });
    if (stopped_) return;
    busy_ = true;
    Task task = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    task.work();
    task = {};
    lock.lock();
    busy_ = false;
  }
}

}  // namespace kerf::api
