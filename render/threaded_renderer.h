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

// One thread that owns a canvas and draws for all callers, in the order they came. A canvas that failed is thrown away;
// the next call gets a fresh one.
class ThreadedRenderer final : public Renderer {
 public:
  // Waits until the thread has made its first canvas, or failed to: see available().
  ThreadedRenderer(CanvasFactory factory, const RendererOptions& options);
  // stop(), and returns when all callers have left.
  ~ThreadedRenderer() override;

  ThreadedRenderer(const ThreadedRenderer&) = delete;
  ThreadedRenderer& operator=(const ThreadedRenderer&) = delete;

  Status render(const Scene& scene, const Camera& camera, int width, int height, Pixels& pixels,
                RenderTimes* times = nullptr) override;
  // Whether the first canvas could be made.
  [[nodiscard]] bool available() const override { return available_; }
  // Of the first canvas, or why there was none.
  [[nodiscard]] std::string description() const override { return description_; }
  // Of the first canvas.
  [[nodiscard]] std::vector<DeviceOutcome> devices() const override { return outcomes_; }

  // Finishes the picture being drawn; refuses the calls that wait and all later ones. Returns at once.
  void stop();
  // Calls inside render() whose picture is being prepared, waiting or being drawn.
  [[nodiscard]] int num_calls() const;

 private:
  struct Job {
    const DrawList* list = nullptr;
    Pixels pixels;
    RenderTimes* times = nullptr;  // null: nobody asked
    Status status;
    bool done = false;
  };

  void run(const CanvasFactory& factory);
  // On the render thread; makes a canvas first where there is none.
  static void draw(const CanvasFactory& factory, std::unique_ptr<Canvas>& canvas, Job& job);
  bool admit(Status& refusal);
  void leave();

  const int max_admitted_;
  // Written by the render thread before `started_`, then never again.
  bool available_ = false;
  std::string description_;
  std::vector<DeviceOutcome> outcomes_;

  mutable std::mutex mutex_;
  std::condition_variable work_;  // the render thread waits on it
  std::condition_variable done_;  // callers, the constructor and the destructor do
  std::deque<Job*> waiting_;      // guarded by mutex_, as are the rest
  int num_admitted_ = 0;          // calls inside render()
  bool started_ = false;
  bool stopping_ = false;

  std::thread thread_;
};

}  // namespace kerf::render
