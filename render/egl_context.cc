#include "render/egl_context.h"

// Only this file includes EGL.
#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <array>

namespace kerf::render {

namespace {

Status context_lost(const std::string& words) {
  return {StatusCode::kUnavailable, "CONTEXT_LOST", "the graphics context was lost (" + words + "); try again", ""};
}

Status unavailable(const std::string& words) {
  return {StatusCode::kUnavailable, "RENDERER_UNAVAILABLE", words, ""};
}

std::string hex(unsigned code) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text = "0x";
  for (int shift = 12; shift >= 0; shift -= 4) text += kDigits[(code >> shift) & 0xfU];
  return text;
}

bool has_word(const char* words, const std::string& word) {
  return words != nullptr && (" " + std::string(words) + " ").find(" " + word + " ") != std::string::npos;
}

// Describes a device; if `query` is null, only by its number.
RenderDevice describe(EGLDeviceEXT device, EGLint number, PFNEGLQUERYDEVICESTRINGEXTPROC query) {
  RenderDevice described{"EGL device " + std::to_string(number), "", DeviceKind::kHardware};
  const char* extensions = query != nullptr ? query(device, EGL_EXTENSIONS) : nullptr;
  const auto add = [&](const char* extension, EGLint name) {
    const char* words = has_word(extensions, extension) ? query(device, name) : nullptr;
    if (words != nullptr) described.details += (described.details.empty() ? "" : ", ") + std::string(words);
  };
  if (has_word(extensions, "EGL_MESA_device_software")) {
    described.kind = DeviceKind::kSoftware;
    described.details = "software";
  }
  add("EGL_EXT_device_query_name", EGL_VENDOR);
  add("EGL_EXT_device_query_name", EGL_RENDERER_EXT);
  add("EGL_EXT_device_drm", EGL_DRM_DEVICE_FILE_EXT);
  add("EGL_EXT_device_drm_render_node", EGL_DRM_RENDER_NODE_FILE_EXT);
  return described;
}

}  // namespace

std::vector<EglPlatform> egl_platforms() {
  const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  std::vector<EglPlatform> found;
  const auto query_devices = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
  const auto query_device_string =
      reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(eglGetProcAddress("eglQueryDeviceStringEXT"));
  const bool enumerable =
      has_word(extensions, "EGL_EXT_device_enumeration") || has_word(extensions, "EGL_EXT_device_base");
  if (enumerable && has_word(extensions, "EGL_EXT_platform_device") && query_devices != nullptr) {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    if (query_devices(static_cast<EGLint>(devices.size()), devices.data(), &count) == EGL_FALSE) count = 0;
    for (EGLint i = 0; i < count; ++i) {
      EGLDeviceEXT device = devices[static_cast<std::size_t>(i)];
      found.push_back({describe(device, i, query_device_string), EGL_PLATFORM_DEVICE_EXT, device});
    }
  }
  if (has_word(extensions, "EGL_MESA_platform_surfaceless")) {
    found.push_back(
        {{"EGL surfaceless", "", DeviceKind::kUnknown}, EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY});
  }
  return found;
}

EglContext::~EglContext() {
  // Leaves the display initialised: the process has only one, and other contexts may use it.
  if (context_ == EGL_NO_CONTEXT) return;
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
  eglReleaseThread();
}

Status EglContext::open(const EglPlatform& platform) {
  const auto failed = [](const std::string& call) {
    return unavailable(call + " failed with " + hex(static_cast<unsigned>(eglGetError())));
  };
  const auto get_display =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  if (get_display == nullptr) return unavailable("EGL has no eglGetPlatformDisplayEXT");
  display_ = get_display(platform.kind, platform.handle, nullptr);
  if (display_ == EGL_NO_DISPLAY) return failed("eglGetPlatformDisplayEXT");
  if (eglInitialize(display_, nullptr, nullptr) == EGL_FALSE) return failed("eglInitialize");
  if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) return failed("eglBindAPI");
  const char* extensions = eglQueryString(display_, EGL_EXTENSIONS);
  if (!has_word(extensions, "EGL_KHR_surfaceless_context")) {
    return unavailable("no EGL_KHR_surfaceless_context");
  }
  const std::array<EGLint, 5> wanted{EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint num_configs = 0;
  if (eglChooseConfig(display_, wanted.data(), &config, 1, &num_configs) == EGL_FALSE || num_configs < 1) {
    return failed("eglChooseConfig");
  }
  std::vector<EGLint> attributes{EGL_CONTEXT_MAJOR_VERSION,       3,
                                 EGL_CONTEXT_MINOR_VERSION,       3,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT};
  tells_resets_ = has_word(extensions, "EGL_EXT_create_context_robustness");
  if (tells_resets_) {
    attributes.insert(attributes.end(), {EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_LOSE_CONTEXT_ON_RESET});
  }
  attributes.push_back(EGL_NONE);
  context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, attributes.data());
  if (context_ == EGL_NO_CONTEXT) return failed("eglCreateContext (OpenGL 3.3 core)");
  if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE) return failed("eglMakeCurrent");
  return {};
}

Status EglContext::check() const {
  if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE) {
    return context_lost("EGL error " + hex(static_cast<unsigned>(eglGetError())));
  }
  return {};
}

void* EglContext::function(const char* name) {
  return reinterpret_cast<void*>(eglGetProcAddress(name));
}

}  // namespace kerf::render
