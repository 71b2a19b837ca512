#pragma once

#include <string>
#include <vector>

#include "render/renderer.h"

namespace kerf::render {

struct EglPlatform {
  RenderDevice device;
  unsigned kind = 0;       // EGLenum
  void* handle = nullptr;  // what the platform of that kind takes
};

// EGL's devices in its order, "EGL device N" at index N, then Mesa's surfaceless platform; those that this machine
// offers.
std::vector<EglPlatform> egl_platforms();

// An OpenGL 3.3 core context without a surface, current on the thread that opened it.
class EglContext {
 public:
  EglContext() = default;
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  // Once. Errors: "RENDERER_UNAVAILABLE".
  Status open(const EglPlatform& platform);
  // Makes it current again. Errors: "CONTEXT_LOST".
  [[nodiscard]] Status check() const;
  // Whether the context was asked to tell of resets, with OpenGL's graphics reset status.
  [[nodiscard]] bool tells_resets() const { return tells_resets_; }
  // An OpenGL entry point; not null even for some that the driver lacks, so ask its extensions first.
  static void* function(const char* name);

 private:
  void* display_ = nullptr;  // EGLDisplay
  void* context_ = nullptr;  // EGLContext
  bool tells_resets_ = false;
};

}  // namespace kerf::render
