#include "render/null_renderer.h"

// Replaces egl_renderer.cc in builds without EGL.
namespace kerf::render {

namespace {

constexpr const char* kReason = "built without EGL (KERF_RENDER=OFF, or libegl-dev and libopengl-dev were missing)";

}  // namespace

Status check_device(const std::string& device) {
  if (device == kAnyDevice || device == kNoDevice) return {};
  return {StatusCode::kInvalidArgument, "UNKNOWN_DEVICE", "\"" + device + "\" is not a device here: " + kReason,
          "device"};
}

std::unique_ptr<Renderer> make_renderer(const RendererOptions& options) {
  return make_null_renderer(options.device == kNoDevice ? "switched off" : kReason);
}

std::vector<DeviceOutcome> probe_devices() {
  return {};
}

}  // namespace kerf::render
