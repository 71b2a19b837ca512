// From a tick to the bytes of a picture, stage by stage: see README.md, "From a tick to a picture". Exits with 1 where
// a picture is not what it should be.

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "render/renderer.h"
#include "server/api/picture.h"
#include "server/api/video_track.h"
#include "tests/bench/scenes.h"

namespace kerf::bench {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr int kWarmUp = 3;
constexpr int kPictures = 21;

double ms_since(SteadyClock::time_point start) {
  return std::chrono::duration<double, std::milli>(SteadyClock::now() - start).count();
}

// Asks for the times of each picture.
class TimedRenderer : public render::Renderer {
 public:
  render::Status render(const render::Scene& scene, const render::Camera& camera, int width, int height,
                        render::Pixels& pixels, render::RenderTimes*) override {
    return renderer_->render(scene, camera, width, height, pixels, &times);
  }
  [[nodiscard]] bool available() const override { return renderer_->available(); }
  [[nodiscard]] std::string description() const override { return renderer_->description(); }

  render::RenderTimes times;

 private:
  std::unique_ptr<render::Renderer> renderer_ = render::make_renderer();
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// ms each, and bytes.
struct Stages {
  std::vector<double> prepare, draw, read, jpeg, video, jpeg_bytes, video_bytes;
};

// False where a picture is empty, or is another one when it is drawn again.
bool is_right(render::Renderer& renderer, const api::PictureSubject& subject, const api::PictureView& view,
              const render::Pixels& pixels) {
  const Result<api::DrawnPicture> again = api::draw_picture(renderer, subject, view);
  if (!again.ok() || again->pixels.rgba != pixels.rgba) return false;
  const std::size_t middle = 4 * (static_cast<std::size_t>(view.height / 2) * static_cast<std::size_t>(view.width) +
                                  static_cast<std::size_t>(view.width / 2));
  return !std::equal(pixels.rgba.begin(), pixels.rgba.begin() + 4,
                     pixels.rgba.begin() + static_cast<std::ptrdiff_t>(middle));
}

bool measure(TimedRenderer& renderer, sheet::Sheet& sheet, int width, int height, Stages& stages) {
  api::PictureView view;
  view.width = width;
  view.height = height;
  const double pixels = static_cast<double>(width) * height;
  api::VideoTrack video({width, height, 2.0e6 * pixels / (640.0 * 360.0)});
  for (int i = 0; i < kWarmUp + kPictures; ++i) {
    sheet.step({});
    const api::PictureSubject subject{sheet.snapshot(), api::backdrop_of(sheet)};
    const auto start = SteadyClock::now();
    const Result<api::DrawnPicture> picture = api::draw_picture(renderer, subject, view);
    const double drawn_ms = ms_since(start);
    const render::RenderTimes times = renderer.times;
    if (!picture.ok()) return false;
    const auto jpeg_start = SteadyClock::now();
    const Result<std::string> jpeg = api::encode_still(picture->pixels, {true, 80});
    const double jpeg_ms = ms_since(jpeg_start);
    const auto video_start = SteadyClock::now();
    const auto frame = video.encode(picture->pixels, host::Nanoseconds(std::int64_t{33'333'333} * (i + 1)), false);
    const double video_ms = ms_since(video_start);
    if (!jpeg.ok() || !frame.ok() || frame->key != (i == 0)) return false;
    if (i == 0 && !is_right(renderer, subject, view, picture->pixels)) return false;
    if (i < kWarmUp) continue;
    stages.prepare.push_back(drawn_ms - 1.0e3 * (times.draw_s + times.read_s));
    stages.draw.push_back(1.0e3 * times.draw_s);
    stages.read.push_back(1.0e3 * times.read_s);
    stages.jpeg.push_back(jpeg_ms);
    stages.video.push_back(video_ms);
    stages.jpeg_bytes.push_back(static_cast<double>(jpeg->size()));
    stages.video_bytes.push_back(static_cast<double>(frame->bytes.size()));
  }
  return true;
}

int run() {
  TimedRenderer renderer;
  if (!renderer.available() || !render::video_available()) {
    std::fprintf(stderr, "nothing to measure: %s\n", renderer.description().c_str());
    return 1;
  }
  std::printf(
      "%s\n\n| triangles | picture | prepare | draw | read | JPEG | VP8 | all, JPEG | all, VP8 | JPEG, kB | VP8, kB "
      "|\n",
      renderer.description().c_str());
  std::printf("|---|---|---|---|---|---|---|---|---|---|---|\n");
  constexpr int kSides[] = {51, 159};  // 5,000 and 49,928 triangles
  constexpr int kHeights[] = {360, 720, 1080};
  for (const int side : kSides) {
    sheet::Sheet sheet = swinging_cloth(side, sheet::IntegratorKind::kExplicitLeapfrog);
    for (const int height : kHeights) {
      Stages stages;
      if (!measure(renderer, sheet, height * 16 / 9, height, stages)) {
        std::fprintf(stderr, "%d x %d vertices at %dp: a picture is not what it should be\n", side, side, height);
        return 1;
      }
      const double before = median(stages.prepare) + median(stages.draw) + median(stages.read);
      std::printf("| %d | %dp | %.1f | %.1f | %.1f | %.1f | %.1f | %.1f | %.1f | %.1f | %.1f |\n",
                  2 * (side - 1) * (side - 1), height, median(stages.prepare), median(stages.draw), median(stages.read),
                  median(stages.jpeg), median(stages.video), before + median(stages.jpeg),
                  before + median(stages.video), 1.0e-3 * median(stages.jpeg_bytes),
                  1.0e-3 * median(stages.video_bytes));
      std::fflush(stdout);
    }
  }
  return 0;
}

}  // namespace
}  // namespace kerf::bench

int main() {
  return kerf::bench::run();
}
