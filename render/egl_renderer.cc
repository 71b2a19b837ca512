#include <utility>

#include "render/device_choice.h"
#include "render/gl_canvas.h"
#include "render/null_renderer.h"
#include "render/threaded_renderer.h"

namespace kerf::render {

namespace {

std::vector<RenderDevice> devices_of(const std::vector<EglPlatform>& platforms) {
  std::vector<RenderDevice> devices;
  devices.reserve(platforms.size());
  for (const EglPlatform& platform : platforms) devices.push_back(platform.device);
  return devices;
}

// Makes a canvas on the first matching device that works.
Status make_canvas(const std::string& wish, std::unique_ptr<Canvas>& canvas, std::vector<DeviceOutcome>& outcomes) {
  const std::vector<EglPlatform> platforms = egl_platforms();
  const std::vector<RenderDevice> offered = devices_of(platforms);
  std::vector<std::size_t> order;
  if (Status status = devices_to_try(offered, wish, order); !status.ok()) return status;
  const auto open = [&platforms](std::size_t i, std::unique_ptr<Canvas>& opened) {
    return make_gl_canvas(platforms[i], opened);
  };
  return open_first(offered, order, wish, open, outcomes, canvas);
}

}  // namespace

Status check_device(const std::string& device) {
  if (device == kNoDevice) return {};
  std::vector<std::size_t> order;
  return devices_to_try(devices_of(egl_platforms()), device, order);
}

std::unique_ptr<Renderer> make_renderer(const RendererOptions& options) {
  if (options.device == kNoDevice) return make_null_renderer("switched off");
  auto renderer = std::make_unique<ThreadedRenderer>(
      [wish = options.device](std::unique_ptr<Canvas>& canvas, std::vector<DeviceOutcome>& outcomes) {
        return make_canvas(wish, canvas, outcomes);
      },
      options);
  if (renderer->available()) return renderer;
  return make_null_renderer(renderer->description().substr(std::string("none: ").size()), renderer->devices());
}

std::vector<DeviceOutcome> probe_devices() {
  std::vector<DeviceOutcome> outcomes;
  std::unique_ptr<Canvas> canvas;
  static_cast<void>(make_canvas(kAnyDevice, canvas, outcomes));  // A failure is recorded in the outcomes.
  const std::vector<EglPlatform> platforms = egl_platforms();
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    if (outcomes[i].state != DeviceState::kNotTried) continue;
    canvas.reset();  // Before the next canvas is made, because a thread has one current context.
    const Status status = make_gl_canvas(platforms[i], canvas);
    outcomes[i].state = status.ok() ? DeviceState::kUsable : DeviceState::kRejected;
    outcomes[i].words = status.ok() ? canvas->description() : status.message;
  }
  return outcomes;
}

}  // namespace kerf::render
