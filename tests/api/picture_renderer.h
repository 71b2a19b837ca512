#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <new>
#include <semaphore>
#include <string>
#include <vector>

#include "render/renderer.h"

namespace kerf::api {

// Paints each picture in one grey, and notes what it was given; can be made to wait.
class PictureRenderer : public render::Renderer {
 public:
  render::Status render(const render::Scene& scene, const render::Camera& camera, int width, int height,
                        render::Pixels& pixels, render::RenderTimes*) override {
    started.release();
    if (blocked) go.acquire();
    const std::lock_guard lock(mutex_);
    colours_.assign(scene.mesh.vertex_colours.begin(), scene.mesh.vertex_colours.end());
    eyes_.push_back(camera.eye.x);
    if (poor) throw std::bad_alloc();
    if (refusal) return {render::StatusCode::kUnavailable, "CONTEXT_LOST", "gone", ""};
    const auto grey = static_cast<std::uint8_t>(40 * eyes_.size());
    pixels = {width, height, std::vector<std::uint8_t>(4 * static_cast<std::size_t>(width * height), grey)};
    return {};
  }
  [[nodiscard]] bool available() const override { return true; }
  [[nodiscard]] std::string description() const override { return "grey"; }

  [[nodiscard]] std::vector<std::uint8_t> colours() const {
    const std::lock_guard lock(mutex_);
    return colours_;
  }
  [[nodiscard]] std::vector<double> eyes() const {
    const std::lock_guard lock(mutex_);
    return eyes_;
  }

  std::counting_semaphore<1024> started{0};
  std::counting_semaphore<1024> go{0};
  std::atomic<bool> blocked{false};
  std::atomic<bool> refusal{false};
  std::atomic<bool> poor{false};  // there is no memory

 private:
  mutable std::mutex mutex_;
  std::vector<std::uint8_t> colours_;  // of the last picture's vertices
  std::vector<double> eyes_;           // eye.x of each picture
};

}  // namespace kerf::api
