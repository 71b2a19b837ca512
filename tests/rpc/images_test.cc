// RenderService.WatchImages of a whole kerfd with its real renderer, over gRPC.

#include <gtest/gtest.h>
#include <turbojpeg.h>
#include <vpx/vp8dx.h>
#include <vpx/vpx_decoder.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/rpc/images_fixture.h"

namespace kerf::rpc_test {
namespace {

// Brightness, 0..255, row by row.
std::vector<double> decode_jpeg(const std::string& bytes) {
  std::vector<unsigned char> grey(std::size_t{kWidth} * kHeight);
  tjhandle decoder = tjInitDecompress();
  EXPECT_EQ(tjDecompress2(decoder, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), grey.data(),
                          kWidth, 0, kHeight, TJPF_GRAY, 0),
            0);
  tjDestroy(decoder);
  return {grey.begin(), grey.end()};
}

class VideoDecoder {
 public:
  VideoDecoder() { vpx_codec_dec_init(&codec_, vpx_codec_vp8_dx(), nullptr, 0); }
  ~VideoDecoder() { vpx_codec_destroy(&codec_); }
  VideoDecoder(const VideoDecoder&) = delete;
  VideoDecoder& operator=(const VideoDecoder&) = delete;

  // As decode_jpeg(); empty where it cannot be decoded.
  std::vector<double> decode(const std::string& bytes) {
    const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
    if (vpx_codec_decode(&codec_, data, static_cast<unsigned>(bytes.size()), nullptr, 0) != VPX_CODEC_OK) return {};
    vpx_codec_iter_t iterator = nullptr;
    const vpx_image_t* image = vpx_codec_get_frame(&codec_, &iterator);
    if (image == nullptr || image->d_w != kWidth || image->d_h != kHeight) return {};
    std::vector<double> grey;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        grey.push_back((image->planes[VPX_PLANE_Y][y * image->stride[VPX_PLANE_Y] + x] - 16) * 255.0 / 219.0);
      }
    }
    return grey;
  }

 private:
  vpx_codec_ctx_t codec_{};
};

double psnr(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size() || a.empty()) return 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return 10.0 * std::log10(255.0 * 255.0 / (sum / static_cast<double>(a.size())));
}

TEST_F(ImagesTest, VideoShowsWhatTheJpegsShow) {
  if (!video_) GTEST_SKIP() << "built without VP8";
  grpc::ClientContext jpeg_context;
  grpc::ClientContext video_context;
  const auto jpegs = open(jpeg_context);
  const auto video = open(video_context);
  jpegs->Write(start_of(v1::IMAGE_JPEG));
  video->Write(start_of(v1::IMAGE_VP8));
  VideoDecoder decoder;
  for (int tick = 0; tick < 5; ++tick) {
    const v1::Image still = read(*jpegs);
    const v1::Image frame = read(*video);
    EXPECT_EQ(still.tick(), tick);
    EXPECT_EQ(frame.tick(), tick);
    EXPECT_EQ(frame.key(), tick == 0);
    EXPECT_GT(psnr(decode_jpeg(still.data()), decoder.decode(frame.data())), 28.0) << tick;
    step();
  }
}

TEST_F(ImagesTest, AStreamEndsWithItsSheet) {
  grpc::ClientContext context;
  const auto stream = open(context);
  stream->Write(start_of(v1::IMAGE_PNG));
  EXPECT_EQ(read(*stream).data().substr(1, 3), "PNG");
  v1::DeleteSheetRequest request;
  request.set_name("sheets/a");
  google::protobuf::Empty empty;
  ASSERT_TRUE(client_->call(&v1::SheetService::Stub::DeleteSheet, client_->sheets(), request, empty).ok());
  v1::WatchImagesResponse last;
  ASSERT_TRUE(stream->Read(&last));
  EXPECT_EQ(last.ended().reason(), v1::Ended::SHEET_DELETED);
  EXPECT_FALSE(stream->Read(&last));
  EXPECT_TRUE(stream->Finish().ok());
}

}  // namespace
}  // namespace kerf::rpc_test
