#pragma once

#include <memory>

#include "render/canvas.h"
#include "render/egl_context.h"

namespace kerf::render {

// Makes an OpenGL canvas on the given platform. Errors: "RENDERER_UNAVAILABLE" (no context), "DRAWING_FAILED" (the
// driver rejects our shaders).
Status make_gl_canvas(const EglPlatform& platform, std::unique_ptr<Canvas>& canvas);

}  // namespace kerf::render
