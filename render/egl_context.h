#pragma once

#include <string>
#include <vector>

#include "render/renderer.h"

namespace kerf::render {

struct EglPlatform {
  RenderDevice device;
  unsigned kind = 0;       // EGLenum
  void* handle = nullptr;  // Native handle for a platform of this kind.
};

// Lists the EGL devices of this machine in EGL's order, "EGL device N" at index N, then Mesa's surfaceless platform.
std::vector<EglPlatform> egl_platforms();

// Represents an OpenGL 3.3 core context without a surface, current on the thread that opened it.
class EglContext {
 public:
  EglContext() = default;
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  // Opens the context; to be called once. Errors: "RENDERER_UNAVAILABLE".
  Status open(const EglPlatform& platform);
  // Makes the context current again. Errors: "CONTEXT_LOST".
  [[nodiscard]] Status check() const;
  // True if OpenGL's graphics reset status reports when a reset has destroyed the context.
  [[nodiscard]] bool tells_resets() const { return tells_resets_; }
  // Returns an OpenGL entry point. The pointer may be non-null for functions that the driver lacks, so check the
  // extensions first.
  static void* function(const char* name);

 private:
  void* display_ = nullptr;  // EGLDisplay
  void* context_ = nullptr;  // EGLContext
  bool tells_resets_ = false;
};

}  // namespace kerf::render
