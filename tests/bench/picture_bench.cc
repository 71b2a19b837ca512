// From a tick to the bytes of a picture, stage by stage: see notes/pictures.md. Exits with 1 where
// a picture is not what it should be.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/renderer.h"
#include "server/service/api/image_request.h"
#include "server/service/picture/picture.h"
#include "server/service/picture/video_track.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/picture_check.h"
#include "tests/bench/scenes.h"

namespace kerf::bench {
namespace {

constexpr int kWarmUp = 3;
constexpr int kPictures = 21;
constexpr int kSides[] = {51, 159};  // vertices: 5,000 and 49,928 triangles
constexpr int kHeights[] = {360, 720, 1080};
constexpr double kMinPsnr = 28.0;     // dB, of JPEG and VP8
constexpr double kMinCovered = 0.02;  // of the picture, by the sheet and its shadow

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

// ms of CPU time each, and bytes.
struct Stages {
  std::vector<double> prepare, draw, read, jpeg, video, png, jpeg_bytes, video_bytes, png_bytes;
};

// The bytes of an encoder's answer, and how long it took.
struct Encoded {
  std::string bytes;
  double ms = 0.0;

  [[nodiscard]] std::span<const std::uint8_t> span() const {
    return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
  }
};

template <typename Encode>
Result<Encoded> timed(const Encode& encode) {
  const double start_s = thread_cpu_s();
  Result<std::string> bytes = encode();
  const double ms = 1.0e3 * (thread_cpu_s() - start_s);
  if (!bytes.ok()) return bytes.error();
  return Encoded{std::move(*bytes), ms};
}

// Measures an image stream of one size, and checks it.
class Measurement {
 public:
  Measurement(TimedRenderer& renderer, int height) : renderer_(renderer), look_(look_of(height)), video_(look_.video) {}

  // Empty where all is right.
  std::string run(sheet::Sheet& sheet) {
    for (int i = 0; i < kWarmUp + kPictures; ++i) {
      sheet.step({});
      if (std::string fault = take({sheet.snapshot(), picture::backdrop_of(sheet)}, i); !fault.empty()) return fault;
    }
    return {};
  }

  Stages stages;

 private:
  static api::ImageLook look_of(int height) {
    v1::ImageView view;
    view.set_width_px(height * 16 / 9);
    view.set_height_px(height);
    return *api::decode_look(view, v1::IMAGE_VP8, "view.");
  }

  std::string take(const picture::PictureSubject& subject, int i) {
    const double start_s = process_cpu_s();
    const double thread_start_s = thread_cpu_s();
    const Result<picture::DrawnPicture> picture = picture::draw_picture(renderer_, subject, look_.view);
    const double prepared_s = thread_cpu_s() - thread_start_s;  // this thread waits while others draw and read
    const double drawn_s = process_cpu_s() - start_s - prepared_s;
    const render::RenderTimes times = renderer_.times;
    if (!picture.ok()) return picture.error().message;
    const render::Pixels& pixels = picture->pixels;
    const auto jpeg = timed([&] { return picture::encode_still(pixels, {true, 80}); });
    const auto png = timed([&] { return picture::encode_still(pixels, {false, 0}); });
    bool key = false;
    const auto video = timed([&]() -> Result<std::string> {
      auto frame = video_.encode(pixels, host::Nanoseconds(std::int64_t{33'333'333} * (i + 1)), false);
      if (!frame.ok()) return frame.error();
      key = frame->key;
      return std::move(frame->bytes);
    });
    if (!jpeg.ok() || !png.ok() || !video.ok()) return "it cannot be encoded";
    if (key != (i == 0)) return "VP8: the first frame, and no other, is a key frame";
    if (std::string fault = video_check_.fault(video->span(), pixels, kMinPsnr); !fault.empty()) return "VP8: " + fault;
    if (i < kWarmUp) return {};
    note(prepared_s, drawn_s, times, *jpeg, *png, *video);
    return i == kWarmUp ? first_fault(subject, pixels, *jpeg, *png) : std::string();
  }

  void note(double prepared_s, double drawn_s, const render::RenderTimes& times, const Encoded& jpeg,
            const Encoded& png, const Encoded& video) {
    const double read_share = times.read_s / (times.draw_s + times.read_s);
    stages.prepare.push_back(1.0e3 * prepared_s);
    stages.draw.push_back(1.0e3 * drawn_s * (1.0 - read_share));
    stages.read.push_back(1.0e3 * drawn_s * read_share);
    stages.jpeg.push_back(jpeg.ms);
    stages.png.push_back(png.ms);
    stages.video.push_back(video.ms);
    stages.jpeg_bytes.push_back(static_cast<double>(jpeg.bytes.size()));
    stages.png_bytes.push_back(static_cast<double>(png.bytes.size()));
    stages.video_bytes.push_back(static_cast<double>(video.bytes.size()));
  }

  std::string first_fault(const picture::PictureSubject& subject, const render::Pixels& pixels, const Encoded& jpeg,
                          const Encoded& png) {
    if (covered_share(pixels) < kMinCovered) return "it is blank";
    const Result<picture::DrawnPicture> again = picture::draw_picture(renderer_, subject, look_.view);
    if (!again.ok() || again->pixels.rgba != pixels.rgba) return "it is another one when it is drawn again";
    if (std::string fault = jpeg_fault(jpeg.span(), pixels, kMinPsnr); !fault.empty()) return "JPEG: " + fault;
    if (std::string fault = png_fault(png.span(), pixels); !fault.empty()) return "PNG: " + fault;
    return {};
  }

  TimedRenderer& renderer_;
  const api::ImageLook look_;
  picture::VideoTrack video_;
  VideoCheck video_check_;
};

void print(int triangles, int height, const Stages& stages) {
  const double drawn = median(stages.prepare) + median(stages.draw) + median(stages.read);
  std::printf("| %d | %dp | %.1f | %.1f | %.1f |", triangles, height, median(stages.prepare), median(stages.draw),
              median(stages.read));
  for (const auto* encode : {&stages.jpeg, &stages.video, &stages.png}) {
    std::printf(" %.1f | %.1f |", median(*encode), drawn + median(*encode));
  }
  for (const auto* bytes : {&stages.jpeg_bytes, &stages.video_bytes, &stages.png_bytes}) {
    std::printf(" %.1f |", 1.0e-3 * median(*bytes));
  }
  std::printf("\n");
  std::fflush(stdout);
}

int run() {
  TimedRenderer renderer;
  if (!renderer.available()) {
    std::fprintf(stderr, "nothing to measure: %s\n", renderer.description().c_str());
    return 1;
  }
  std::printf("%s\n\n", renderer.description().c_str());
  std::printf(
      "| triangles | picture | prepare | draw | read | JPEG | all | VP8 | all | PNG | all | JPEG, kB | VP8, kB | PNG, "
      "kB |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const int side : kSides) {
    sheet::Sheet sheet = swinging_cloth(side, scene::IntegratorKind::kExplicitLeapfrog);
    for (const int height : kHeights) {
      Measurement measurement(renderer, height);
      if (const std::string fault = measurement.run(sheet); !fault.empty()) {
        std::fprintf(stderr, "%d x %d vertices at %dp: the picture is wrong: %s\n", side, side, height, fault.c_str());
        return 1;
      }
      print(2 * (side - 1) * (side - 1), height, measurement.stages);
    }
  }
  return 0;
}

}  // namespace
}  // namespace kerf::bench

int main() {
  return kerf::bench::run();
}
