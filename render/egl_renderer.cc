#include <string>
#include <utility>

#include "render/gl_canvas.h"
#include "render/null_renderer.h"
#include "render/threaded_renderer.h"

namespace kerf::render {

namespace {

// On the first platform that takes one.
Status make_canvas(std::unique_ptr<Canvas>& canvas) {
  std::string reasons;
  for (const EglPlatform& platform : egl_platforms()) {
    Status status = make_gl_canvas(platform, canvas);
    if (status.ok()) return status;
    reasons += (reasons.empty() ? "" : "; ") + status.message;
  }
  if (reasons.empty()) reasons = "EGL offers neither devices nor a surfaceless platform (apt install libegl-mesa0)";
  return {StatusCode::kUnavailable, "RENDERER_UNAVAILABLE", reasons, ""};
}

}  // namespace

std::unique_ptr<Renderer> make_renderer(const RendererOptions& options) {
  auto renderer = std::make_unique<ThreadedRenderer>(make_canvas, options);
  if (renderer->available()) return renderer;
  return make_null_renderer(renderer->description().substr(std::string("none: ").size()));
}

}  // namespace kerf::render
