// Tests the errors that a client gets for a refused file.

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "server/service/ws/http_server.h"
#include "tests/api/fixture.h"
#include "tests/ws/raw_client.h"

namespace kerf::ws_test {
namespace {

constexpr const char* kObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

class UploadTest : public api::ApiTest {
 protected:
  void serve(const api::Limits& limits = {}) {
    make_api(limits, nullptr);
    http_ = std::make_unique<ws::HttpServer>(*api_, ws::AssetTable(), [](const auto&) { return std::string(); });
    port_ = http_->start({"127.0.0.1", 0}).value();
  }
  ~UploadTest() override { http_.reset(); }  // before the Api

  [[nodiscard]] Response upload(const char* headers = "") const {
    return request(port_, "POST", "/sheets?format=obj", headers, kObj);
  }

  std::unique_ptr<ws::HttpServer> http_;
  int port_ = 0;
};

TEST_F(UploadTest, AServerThatStopsSaysSo) {
  serve();
  EXPECT_EQ(upload().status, 200);
  api_->stop();
  const Response stopping = upload();
  EXPECT_EQ(stopping.status, 503);
  EXPECT_NE(stopping.body.find("SERVER_STOPPING"), std::string::npos) << stopping.body;
}

TEST_F(UploadTest, TooManyAtOnceAreTold) {
  api::Limits limits;
  limits.max_uploading_bytes = 10;
  serve(limits);
  const Response full = upload();
  EXPECT_EQ(full.status, 429);
  EXPECT_NE(full.body.find("TOO_MANY_UPLOADS"), std::string::npos) << full.body;
}

TEST_F(UploadTest, FilesFromElsewhereAreRefusedWhateverTheirLength) {
  serve();
  constexpr const char* kElsewhere = "Origin: http://elsewhere.example\r\n";
  const Response small = upload(kElsewhere);
  EXPECT_EQ(small.status, 403);
  const std::string head = "POST /recordings HTTP/1.1\r\nHost: localhost\r\n" + std::string(kElsewhere);
  for (const char* length : {"1048576", "1048577", "134217729"}) {
    RawClient client(port_);
    client.send(head + "Content-Length: " + length + "\r\n\r\n");
    const Response refused = client.read_response();
    EXPECT_EQ(refused.status, 403) << length;
    EXPECT_NE(refused.body.find("ORIGIN_NOT_ALLOWED"), std::string::npos) << refused.body;
  }
}

}  // namespace
}  // namespace kerf::ws_test
