#include <gtest/gtest.h>
#include <png.h>
#include <turbojpeg.h>

#include <cmath>

#include "render/image.h"
#include "server/base/random.h"

namespace kerf::render {
namespace {

Pixels random_pixels(int width, int height) {
  SeededRandom random(7);
  Pixels pixels{width, height, {}};
  for (int i = 0; i < 4 * width * height; ++i) pixels.rgba.push_back(static_cast<std::uint8_t>(random.below(256)));
  return pixels;
}

// Smooth colours, as JPEG is made for; red to the right, green downwards.
Pixels gradient(int width, int height) {
  Pixels pixels{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (const int channel : {255 * x / width, 255 * y / height, 100, 255}) {
        pixels.rgba.push_back(static_cast<std::uint8_t>(channel));
      }
    }
  }
  return pixels;
}

Pixels decode_png(const std::vector<std::uint8_t>& png) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&image, png.data(), png.size()), 0) << image.message;
  image.format = PNG_FORMAT_RGBA;
  Pixels pixels{static_cast<int>(image.width), static_cast<int>(image.height), {}};
  pixels.rgba.resize(PNG_IMAGE_SIZE(image));
  EXPECT_NE(png_image_finish_read(&image, nullptr, pixels.rgba.data(), 0, nullptr), 0) << image.message;
  return pixels;
}

Pixels decode_jpeg(const std::vector<std::uint8_t>& jpeg) {
  const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), tjDestroy);
  Pixels pixels;
  int subsampling = 0;
  int colours = 0;
  EXPECT_EQ(tjDecompressHeader3(decoder.get(), jpeg.data(), jpeg.size(), &pixels.width, &pixels.height, &subsampling,
                                &colours),
            0);
  pixels.rgba.resize(static_cast<std::size_t>(4 * pixels.width * pixels.height));
  EXPECT_EQ(tjDecompress2(decoder.get(), jpeg.data(), jpeg.size(), pixels.rgba.data(), pixels.width, 0, pixels.height,
                          TJPF_RGBA, 0),
            0);
  return pixels;
}

double mean_difference(const Pixels& a, const Pixels& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
    sum += std::abs(static_cast<int>(a.rgba[i]) - static_cast<int>(b.rgba[i]));
  return sum / static_cast<double>(a.rgba.size());
}

TEST(RenderImage, PngComesBackExactly) {
  ASSERT_TRUE(image_codecs_available());
  for (const Pixels& pixels : {random_pixels(1, 1), random_pixels(37, 23), gradient(320, 200)}) {
    std::vector<std::uint8_t> png;
    ASSERT_TRUE(encode_png(pixels, png).ok());
    const Pixels decoded = decode_png(png);
    EXPECT_EQ(decoded.width, pixels.width);
    EXPECT_EQ(decoded.height, pixels.height);
    EXPECT_EQ(decoded.rgba, pixels.rgba);
  }
}

TEST(RenderImage, JpegComesBackNearlyAndBetterWithQuality) {
  const Pixels pixels = gradient(320, 200);
  double last_difference = 1e9;
  std::size_t last_size = 0;
  for (const int quality : {1, 50, 100}) {
    std::vector<std::uint8_t> jpeg;
    ASSERT_TRUE(encode_jpeg(pixels, quality, jpeg).ok());
    const Pixels decoded = decode_jpeg(jpeg);
    ASSERT_EQ(decoded.width, 320);
    ASSERT_EQ(decoded.height, 200);
    const double difference = mean_difference(pixels, decoded);
    EXPECT_LT(difference, last_difference) << quality;
    EXPECT_GT(jpeg.size(), last_size) << quality;
    last_difference = difference;
    last_size = jpeg.size();
  }
  EXPECT_LT(last_difference, 1.0);
}

TEST(RenderImage, BadArgumentsAreRefused) {
  std::vector<std::uint8_t> out{1, 2, 3};
  Pixels short_pixels = gradient(8, 8);
  short_pixels.rgba.pop_back();
  for (const Pixels& bad : {Pixels{}, short_pixels, Pixels{-8, -8, gradient(8, 8).rgba}}) {
    EXPECT_EQ(encode_png(bad, out).reason, "IMAGE_INVALID");
    EXPECT_TRUE(out.empty());
    EXPECT_EQ(encode_jpeg(bad, 80, out).reason, "IMAGE_INVALID");
  }
  for (const int quality : {0, 101, -5}) {
    const Status status = encode_jpeg(gradient(8, 8), quality, out);
    EXPECT_EQ(status.code, StatusCode::kInvalidArgument);
    EXPECT_EQ(status.reason, "QUALITY_OUT_OF_RANGE");
    EXPECT_EQ(status.field, "quality");
    EXPECT_TRUE(out.empty());
  }
}

}  // namespace
}  // namespace kerf::render
