#include <gtest/gtest.h>

#include <cstdlib>

#include "render/renderer.h"

namespace kerf::render {
namespace {

// With no EGL driver to be found, as on a machine without any: the loader (libglvnd) is pointed at none. In a build
// without EGL there is nothing to find anyway.
TEST(RenderAbsent, TheNullRendererSaysWhyAndGoesOn) {
  ASSERT_EQ(setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/dev/null", 1), 0);
  const std::unique_ptr<Renderer> renderer = make_renderer();
  EXPECT_FALSE(renderer->available());
  EXPECT_EQ(renderer->description().rfind("none: ", 0), 0U) << renderer->description();
  EXPECT_GT(renderer->description().size(), std::string("none: ").size() + 10) << renderer->description();
  for (int attempt = 0; attempt < 2; ++attempt) {
    Pixels pixels;
    const Status status = renderer->render(Scene{}, Camera{}, 64, 64, pixels);
    EXPECT_EQ(status.code, StatusCode::kUnavailable);
    EXPECT_EQ(status.reason, "RENDERER_UNAVAILABLE");
    EXPECT_TRUE(pixels.rgba.empty());
  }
}

}  // namespace
}  // namespace kerf::render
