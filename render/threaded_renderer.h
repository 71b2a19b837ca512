#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "render/canvas.h"
#include "render/renderer.h"

namespace kerf::render {

// Runs one thread that owns a canvas and draws for all callers, in the order of their calls. A failed canvas is
// destroyed; the next call makes a new one.
class ThreadedRenderer final : public Renderer {
 public:
  // Waits until the thread has made its first canvas, or failed to: see available().
  ThreadedRenderer(CanvasFactory factory, const RendererOptions& options);
  // Calls stop() and waits until all callers have left.
  ~ThreadedRenderer() override;

  ThreadedRenderer(const ThreadedRenderer&) = delete;
  ThreadedRenderer& operator=(const ThreadedRenderer&) = delete;

  Status render(const Scene& scene, const Camera& camera, int width, int height, Pixels& pixels,
                RenderTimes* times = nullptr) override;
  // True if the first canvas could be made.
  [[nodiscard]] bool available() const override { return available_; }
  // Describes the first canvas, or the reason why there was none.
  [[nodiscard]] std::string description() const override { return description_; }
  // Returns the outcomes of making the first canvas.
  [[nodiscard]] std::vector<DeviceOutcome> devices() const override { return outcomes_; }

  // Makes waiting and later calls of render() fail; the picture being drawn is still finished. Returns at once.
  void stop();
  // Counts calls of render() whose picture is being prepared, waiting or being drawn.
  [[nodiscard]] int num_calls() const;

 private:
  struct Job {
    const DrawList* list = nullptr;
    Pixels pixels;
    RenderTimes* times = nullptr;  // Null: not wanted.
    Status status;
    bool done = false;
  };

  void run(const CanvasFactory& factory);
  // Draws a job on the render thread; makes a canvas first if there is none.
  static void draw(const CanvasFactory& factory, std::unique_ptr<Canvas>& canvas, Job& job);
  bool admit(Status& refusal);
  void leave();

  const int max_admitted_;
  // These three are written by the render thread before it sets `started_`, and never change afterwards.
  bool available_ = false;
  std::string description_;
  std::vector<DeviceOutcome> outcomes_;

  mutable std::mutex mutex_;
  std::condition_variable work_;  // The render thread waits on it.
  std::condition_variable done_;  // Callers, the constructor and the destructor wait on it.
  std::deque<Job*> waiting_;      // Guarded by mutex_, as are the next three.
  int num_admitted_ = 0;          // Calls of render() that were admitted and have not returned.
  bool started_ = false;
  bool stopping_ = false;

  std::thread thread_;
};

}  // namespace kerf::render
