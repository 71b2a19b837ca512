#include "server/service/picture/background_worker.h"

#include <utility>

namespace kerf::picture {

BackgroundWorker::BackgroundWorker(std::size_t max_waiting, std::size_t num_threads)
    : max_waiting_(max_waiting), idle_(num_threads) {
  for (std::size_t i = 0; i < num_threads; ++i) threads_.emplace_back([this] { run(); });
}

BackgroundWorker::~BackgroundWorker() {
  stop();
}

BackgroundWorker::Outcome BackgroundWorker::submit(std::function<void()> work, std::function<void()> refuse) {
  {
    const std::lock_guard lock(mutex_);
    if (stopped_) return Outcome::kStopped;
    // Does not count pieces that idle threads are about to take.
    if (waiting_.size() >= idle_ && waiting_.size() - idle_ >= max_waiting_) return Outcome::kFull;
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
  for (std::thread& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
}

void BackgroundWorker::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stopped_ || !waiting_.empty(); });
    if (stopped_) return;
    --idle_;
    Task task = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    task.work();
    task = {};
    lock.lock();
    ++idle_;
  }
}

}  // namespace kerf::picture
