#pragma once

#include <cstdint>
#include <string>

#include "render/image.h"
#include "tests/api/fixture.h"
#include "tests/api/image_viewer.h"
#include "tests/api/picture_renderer.h"

// An Api with a renderer that counts, and image streams of it.
namespace kerf::api {

class ImagesTest : public ApiTest {
 protected:
  void SetUp() override {
    if (!render::image_codecs_available()) GTEST_SKIP() << "built without image libraries";
    make_api({}, &renderer_);
  }
  ~ImagesTest() override { api_.reset(); }  // before the renderer

  // Answered when the stream is joined to its sheet.
  void start(ImageViewer& viewer, const v1::WatchImagesRequest& request) {
    viewer.send(request);
    host_->wait_idle();
  }
  void start(ImageViewer& viewer, const std::string& name, int window = 0, double max_rate_hz = 0.0) {
    viewer.start(name, window, max_rate_hz);
    host_->wait_idle();
  }
  std::int64_t rendered() { return api_->picture_counts().rendered; }

  PictureRenderer renderer_;
};

}  // namespace kerf::api
