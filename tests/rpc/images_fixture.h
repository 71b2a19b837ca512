#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>

#include "client/cpp/client.h"
#include "tests/ws/running_server.h"

// A whole kerfd with its real renderer and a paused sheet, and readers of pictures of it over gRPC. Tests are skipped
// where the machine draws none.
namespace kerf::rpc_test {

inline constexpr int kWidth = 320;
inline constexpr int kHeight = 240;

using ImageStream = grpc::ClientReaderWriter<v1::WatchImagesRequest, v1::WatchImagesResponse>;

class ImagesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    config_.render = true;
    server_ = ws_test::start_server(config_);
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

  std::unique_ptr<ImageStream> open(grpc::ClientContext& context) {
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
  static v1::Image read(ImageStream& stream) {
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

  app::Config config_ = ws_test::test_config();
  std::unique_ptr<app::Server> server_;
  std::unique_ptr<client::Client> client_;
  bool video_ = false;
};

}  // namespace kerf::rpc_test
