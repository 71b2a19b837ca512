// RenderService.WatchImages of a whole kerfd with its real renderer, over gRPC.

#include <gtest/gtest.h>
#include <turbojpeg.h>
#include <vpx/vp8dx.h>
#include <vpx/vpx_decoder.h>

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/cpp/client.h"
#include "client/cpp/failure.h"
#include "tests/ws/running_server.h"

namespace kerf::rpc_test {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

using Stream = grpc::ClientReaderWriter<v1::WatchImagesRequest, v1::WatchImagesResponse>;

class ImagesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    app::Config config = ws_test::test_config();
    config.render = true;
    server_ = ws_test::start_server(config);
    ASSERT_NE(server_, nullptr);
    client_ = std::make_unique<client::Client>(server_->grpc_address());
    v1::ServerInfo info;
    ASSERT_TRUE(client_->call(&v1::ServerService::Stub::GetServerInfo, client_->server(), {}, info).ok());
    if (info.renderer().starts_with("none: ")) GTEST_SKIP() << info.renderer();
    video_ = info.video();
    EXPECT_GT(info.limits().max_image_streams(), 0);
    v1::CreateSheetRequest request;
    request.set_sheet_id("a");
    request.set_paused(true);
    v1::GridMesh& grid = *request.mutable_scene()->mutable_grid();
    grid.set_columns(10);
    grid.set_rows(10);
    grid.set_width_m(1.0);
    grid.set_height_m(1.0);
    v1::Sheet sheet;
    ASSERT_TRUE(client_->call(&v1::SheetService::Stub::CreateSheet, client_->sheets(), request, sheet).ok());
  }

  std::unique_ptr<Stream> open(grpc::ClientContext& context) {
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(60));
    return client_->render().WatchImages(&context);
  }
  static v1::WatchImagesRequest start_of(v1::ImageCodec codec) {
    v1::WatchImagesRequest request;
    v1::WatchImagesStart& start = *request.mutable_start();
    start.set_name("sheets/a");
    start.set_codec(codec);
    start.mutable_view()->set_width_px(kWidth);
    start.mutable_view()->set_height_px(kHeight);
    start.mutable_view()->set_jpeg_quality(95);
    start.mutable_view()->set_bitrate_kbps(4000);
    return request;
  }
  // The next picture, acknowledged.
  static v1::Image read(Stream& stream) {
    v1::WatchImagesResponse response;
    EXPECT_TRUE(stream.Read(&response));
    v1::WatchImagesRequest ack;
    ack.mutable_ack()->set_sequence(response.image().sequence());
    stream.Write(ack);
    return response.image();
  }
  void step() {
    v1::StepSheetRequest request;
    request.set_name("sheets/a");
    request.set_ticks(1);
    v1::Sheet sheet;
    EXPECT_TRUE(client_->call(&v1::SheetService::Stub::StepSheet, client_->sheets(), request, sheet).ok());
  }

  std::unique_ptr<app::Server> server_;
  std::unique_ptr<client::Client> client_;
  bool video_ = false;
};

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

TEST_F(ImagesTest, WhatIsNoProtocolIsRefusedWithItsStatus) {
  const auto refused = [this](const std::vector<v1::WatchImagesRequest>& requests) {
    grpc::ClientContext context;
    const auto stream = open(context);
    for (const v1::WatchImagesRequest& request : requests) stream->Write(request);
    v1::WatchImagesResponse response;
    while (stream->Read(&response)) {
    }
    return stream->Finish();
  };
  v1::WatchImagesRequest ack;
  ack.mutable_ack()->set_sequence(7);
  EXPECT_EQ(refused({ack}).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(refused({v1::WatchImagesRequest()}).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  const v1::WatchImagesRequest start = start_of(v1::IMAGE_JPEG);
  EXPECT_EQ(refused({start, ack}).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(refused({start, start}).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  v1::WatchImagesRequest nobody = start;
  nobody.mutable_start()->set_name("sheets/nobody");
  EXPECT_EQ(refused({nobody}).error_code(), grpc::StatusCode::NOT_FOUND);
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
