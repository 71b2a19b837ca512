#pragma once

#include <memory>

#include "render/canvas.h"
#include "render/egl_context.h"

namespace kerf::render {

// An OpenGL canvas on the platform given. Errors: "RENDERER_UNAVAILABLE" (no context), "DRAWING_FAILED" (the driver
// does not take our shaders).
Status make_gl_canvas(const EglPlatform& platform, std::unique_ptr<Canvas>& canvas);

}  // namespace kerf::render
