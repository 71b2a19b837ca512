#include "render/null_renderer.h"

// Built instead of egl_renderer.cc where there is no EGL.
namespace kerf::render {

std::unique_ptr<Renderer> make_renderer(const RendererOptions& /*options*/) {
  return make_null_renderer("built without EGL (KERF_RENDER=OFF, or libegl-dev and libopengl-dev were missing)");
}

}  // namespace kerf::render
