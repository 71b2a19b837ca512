#include "render/threaded_renderer.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace kerf::render {

namespace {

Status shutting_down() {
  return {StatusCode::kUnavailable, "SHUTTING_DOWN", "the renderer is shutting down", ""};
}

// Describes the canvas, its device, and the devices rejected.
std::string describe(const Canvas& canvas, const std::vector<DeviceOutcome>& outcomes) {
  std::string words = canvas.description();
  std::string rejected;
  for (const auto& [device, state, reason] : outcomes) {
    if (state == DeviceState::kChosen) words = device.name + ", " + words;
    if (state == DeviceState::kRejected) rejected += "; not " + device.name + ": " + reason;
  }
  return words + rejected;
}

}  // namespace

ThreadedRenderer::ThreadedRenderer(CanvasFactory factory, const RendererOptions& options)
    : max_admitted_(std::max(options.max_waiting, 0) + 1),
      thread_([this, factory = std::move(factory)] { run(factory); }) {
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return started_; });
}

ThreadedRenderer::~ThreadedRenderer() {
  stop();
  {
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return num_admitted_ == 0; });
    work_.notify_one();  // Wakes the render thread, which ends when no caller is left.
  }
  thread_.join();
}

void ThreadedRenderer::stop() {
  const std::lock_guard lock(mutex_);
  stopping_ = true;
}

int ThreadedRenderer::num_calls() const {
  const std::lock_guard lock(mutex_);
  return num_admitted_;
}

bool ThreadedRenderer::admit(Status& refusal) {
  const std::lock_guard lock(mutex_);
  if (stopping_) {
    refusal = shutting_down();
    return false;
  }
  if (num_admitted_ >= max_admitted_) {
    refusal = {
        StatusCode::kResourceExhausted, "RENDER_QUEUE_FULL",
        std::to_string(num_admitted_) + " pictures are being drawn or waiting, which is the limit; try again later",
        ""};
    return false;
  }
  ++num_admitted_;
  return true;
}

void ThreadedRenderer::leave() {
  const std::lock_guard lock(mutex_);
  --num_admitted_;
  done_.notify_all();  // Under the lock: once it is released, the destructor may destroy done_.
}

Status ThreadedRenderer::render(const Scene& scene, const Camera& camera, int width, int height, Pixels& pixels,
                                RenderTimes* times) {
  using SteadyClock = std::chrono::steady_clock;
  const auto seconds_since = [](SteadyClock::time_point start) {
    return std::chrono::duration<double>(SteadyClock::now() - start).count();
  };
  if (Status status = validate(scene, camera, width, height); !status.ok()) return status;
  Status refusal;
  if (!admit(refusal)) return refusal;  // Before any work is done for the picture.
  const auto begun = SteadyClock::now();
  const DrawList list = make_draw_list(scene, camera, width, height);
  RenderTimes spent;
  spent.prepare_s = seconds_since(begun);
  Job job;
  job.list = &list;
  if (times != nullptr) job.times = &spent;
  const auto queued = SteadyClock::now();
  {
    std::unique_lock lock(mutex_);
    waiting_.push_back(&job);
    work_.notify_one();
    done_.wait(lock, [&job] { return job.done; });
  }
  leave();
  spent.wait_s = std::max(0.0, seconds_since(queued) - spent.draw_s - spent.read_s);
  if (job.status.ok()) pixels = std::move(job.pixels);
  if (job.status.ok() && times != nullptr) *times = spent;
  return job.status;
}

void ThreadedRenderer::run(const CanvasFactory& factory) {
  std::unique_ptr<Canvas> canvas;
  std::vector<DeviceOutcome> outcomes;
  const Status first = factory(canvas, outcomes);
  std::unique_lock lock(mutex_);
  available_ = first.ok();
  description_ = first.ok() ? describe(*canvas, outcomes) : "none: " + first.message;
  outcomes_ = std::move(outcomes);
  started_ = true;
  done_.notify_all();
  while (true) {
    work_.wait(lock, [this] { return !waiting_.empty() || (stopping_ && num_admitted_ == 0); });
    if (waiting_.empty()) return;
    Job& job = *waiting_.front();
    waiting_.pop_front();
    if (stopping_) {
      job.status = shutting_down();
    } else {
      lock.unlock();
      draw(factory, canvas, job);
      lock.lock();
    }
    job.done = true;
    done_.notify_all();
  }
}

void ThreadedRenderer::draw(const CanvasFactory& factory, std::unique_ptr<Canvas>& canvas, Job& job) {
  if (canvas == nullptr) {
    std::vector<DeviceOutcome> outcomes;
    job.status = factory(canvas, outcomes);
    if (!job.status.ok()) {
      canvas.reset();
      return;
    }
  }
  job.status = canvas->draw(*job.list, job.pixels, job.times);
  if (!job.status.ok()) canvas.reset();
}

}  // namespace kerf::render
