// VP8: what is encoded is decoded by libvpx's own decoder and compared.

#include <vpx/vp8dx.h>
#include <vpx/vpx_decoder.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "render/video.h"

namespace kerf::render {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr double kFrameS = 1.0 / 30.0;

// Grey, with a light square that moves to the right.
Pixels picture(int frame, int width = kWidth, int height = kHeight) {
  Pixels pixels{width, height, std::vector<std::uint8_t>(4 * static_cast<std::size_t>(width * height), 255)};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool inside = x >= 10 + 3 * frame && x < 50 + 3 * frame && y >= 30 && y < 70;
      const auto grey = static_cast<std::uint8_t>(inside ? 220 : 60 + x / 4);
      for (int channel = 0; channel < 3; ++channel) {
        pixels.rgba[4 * static_cast<std::size_t>(y * width + x) + static_cast<std::size_t>(channel)] = grey;
      }
    }
  }
  return pixels;
}

// The same with grain that is another in every frame, so that there is always more to send than bits for it.
Pixels grainy_picture(int frame) {
  Pixels pixels = picture(frame);
  std::uint32_t state = 1U + static_cast<std::uint32_t>(frame);
  for (std::size_t i = 0; i < pixels.rgba.size(); i += 4) {
    state = 1'664'525U * state + 1'013'904'223U;  // Numerical Recipes' generator
    const auto grain = static_cast<std::uint8_t>(state >> 27U);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      pixels.rgba[i + channel] = static_cast<std::uint8_t>(pixels.rgba[i + channel] + grain);
    }
  }
  return pixels;
}

class Decoder {
 public:
  Decoder() { EXPECT_EQ(vpx_codec_dec_init(&codec_, vpx_codec_vp8_dx(), nullptr, 0), VPX_CODEC_OK); }
  ~Decoder() { vpx_codec_destroy(&codec_); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  // Null where the frame cannot be decoded.
  const vpx_image_t* decode(const std::vector<std::uint8_t>& frame) {
    const auto size = static_cast<unsigned>(frame.size());
    if (vpx_codec_decode(&codec_, frame.data(), size, nullptr, 0) != VPX_CODEC_OK) return nullptr;
    vpx_codec_iter_t iterator = nullptr;
    return vpx_codec_get_frame(&codec_, &iterator);
  }

 private:
  vpx_codec_ctx_t codec_{};
};

// dB, of the brightness; BT.601 as libyuv has it.
double psnr(const Pixels& pixels, const vpx_image_t& image) {
  double sum = 0.0;
  for (int y = 0; y < pixels.height; ++y) {
    for (int x = 0; x < pixels.width; ++x) {
      const double grey = pixels.rgba[4 * static_cast<std::size_t>(y * pixels.width + x)];
      const double luma = image.planes[VPX_PLANE_Y][y * image.stride[VPX_PLANE_Y] + x];
      const double error = 16.0 + grey * 219.0 / 255.0 - luma;
      sum += error * error;
    }
  }
  return 10.0 * std::log10(255.0 * 255.0 / (sum / (pixels.width * pixels.height)));
}

std::unique_ptr<VideoEncoder> encoder(double bits_per_second = 800'000.0) {
  std::unique_ptr<VideoEncoder> made;
  const Status status = make_video_encoder({kWidth, kHeight, bits_per_second}, made);
  EXPECT_TRUE(status.ok()) << status.message;
  return made;
}

TEST(Video, FramesDecodeToWhatWasEncoded) {
  const auto video = encoder();
  Decoder decoder;
  std::vector<std::uint8_t> frame;
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(video->encode(picture(i), kFrameS, false, frame).ok());
    EXPECT_EQ(is_key_frame(frame), i == 0);
    const vpx_image_t* image = decoder.decode(frame);
    ASSERT_NE(image, nullptr) << i;
    EXPECT_EQ(image->d_w, static_cast<unsigned>(kWidth));
    EXPECT_GT(psnr(picture(i), *image), 32.0) << i;
  }
}

TEST(Video, AKeyFrameStandsByItself) {
  const auto video = encoder();
  std::vector<std::uint8_t> frame;
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(video->encode(picture(i), kFrameS, i == 4, frame).ok());
  EXPECT_TRUE(is_key_frame(frame));
  Decoder late;
  const vpx_image_t* image = late.decode(frame);
  ASSERT_NE(image, nullptr);
  EXPECT_GT(psnr(picture(4), *image), 32.0);
}

TEST(Video, TheBitRateIsKept) {
  const auto bytes_at = [](double bits_per_second) {
    const auto video = encoder(bits_per_second);
    std::vector<std::uint8_t> frame;
    std::size_t bytes = 0;
    for (int i = 0; i < 90; ++i) {
      EXPECT_TRUE(video->encode(grainy_picture(i % 30), kFrameS, false, frame).ok());
      bytes += frame.size();
    }
    return static_cast<double>(bytes);
  };
  const double low = bytes_at(60'000.0);
  const double high = bytes_at(400'000.0);
  EXPECT_LT(low, 2.0 * 60'000.0 / 8.0 * 3.0) << "three seconds of it, and the key frame";
  EXPECT_GT(high, 3.0 * low);
}

TEST(Video, EqualCallsGiveEqualBytes) {
  const auto first = encoder();
  const auto second = encoder();
  std::vector<std::uint8_t> a;
  std::vector<std::uint8_t> b;
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(first->encode(picture(i), kFrameS, false, a).ok());
    ASSERT_TRUE(second->encode(picture(i), kFrameS, false, b).ok());
    EXPECT_EQ(a, b) << i;
  }
}

TEST(Video, ALongPauseIsNoReasonForAHugeFrame) {
  const auto video = encoder(200'000.0);
  std::vector<std::uint8_t> frame;
  ASSERT_TRUE(video->encode(picture(0), kFrameS, false, frame).ok());
  ASSERT_TRUE(video->encode(picture(1), 3600.0, false, frame).ok());
  EXPECT_LT(frame.size(), 200'000U / 8U);
}

TEST(Video, OddSizesAreTaken) {
  std::unique_ptr<VideoEncoder> odd;
  ASSERT_TRUE(make_video_encoder({33, 17, 100'000.0}, odd).ok());
  std::vector<std::uint8_t> frame;
  ASSERT_TRUE(odd->encode(picture(0, 33, 17), kFrameS, false, frame).ok());
  Decoder decoder;
  const vpx_image_t* image = decoder.decode(frame);
  ASSERT_NE(image, nullptr);
  EXPECT_EQ(image->d_w, 33U);
  EXPECT_EQ(image->d_h, 17U);
}

TEST(Video, WhatCannotBeEncodedIsRefused) {
  std::unique_ptr<VideoEncoder> made;
  EXPECT_TRUE(make_video_encoder({1920, 1200, 1.0e6}, made).ok());
  for (const auto& [width, height] : {std::pair(1921, 1200), std::pair(0, 16), std::pair(16, -1)}) {
    const Status status = make_video_encoder({width, height, 1.0e6}, made);
    EXPECT_EQ(status.reason, "SIZE_OUT_OF_RANGE");
    EXPECT_EQ(made, nullptr);
  }
  const auto video = encoder();
  std::vector<std::uint8_t> frame{1, 2, 3};
  EXPECT_EQ(video->encode(picture(0, 32, 16), kFrameS, false, frame).reason, "IMAGE_INVALID");
  EXPECT_TRUE(frame.empty());
}

}  // namespace
}  // namespace kerf::render
