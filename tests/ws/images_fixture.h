#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>

#include "kerf/v1/render.pb.h"
#include "kerf/v1/server.pb.h"
#include "server/service/wire/json.h"
#include "tests/ws/raw_client.h"
#include "tests/ws/running_server.h"

// A whole kerfd with its real renderer and a paused sheet, and readers of pictures of it. Tests are skipped where the
// machine draws none.
namespace kerf::ws_test {

using Socket = RawWebSocket;

class ImagesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    config_.render = true;
    server_ = start_server(config_);
    ASSERT_NE(server_, nullptr);
    port_ = port_of(server_->http_url());
    v1::ServerInfo info;
    ASSERT_TRUE(wire::from_json(call("ServerService/GetServerInfo", "{}"), info).ok());
    if (info.renderer().starts_with("none: ")) GTEST_SKIP() << info.renderer();
    video_ = info.video();
    call("SheetService/CreateSheet",
         R"({"sheet_id":"a","paused":true,"scene":{"pins":[{"edge":"TOP"}],
             "grid":{"columns":8,"rows":8,"width_m":1,"height_m":1}}})");
  }
  std::string call(const std::string& method, const std::string& json) const {
    const Response answer = request(port_, "POST", "/kerf.v1." + method, {}, json);
    EXPECT_EQ(answer.status, 200) << method << ": " << answer.body;
    return answer.body;
  }
  std::string step() const { return call("SheetService/StepSheet", R"({"name":"sheets/a","ticks":1})"); }
  Response get(const std::string& target) const { return request(port_, "GET", target); }

  [[nodiscard]] double metric(const std::string& name) const {
    const std::string page = get("/metrics").body;
    const std::size_t found = page.find("\n" + name + " ");
    return found == std::string::npos ? -1.0 : std::stod(page.substr(found + name.size() + 2));
  }

  app::Config config_ = test_config();
  std::unique_ptr<app::Server> server_;
  int port_ = 0;
  bool video_ = false;
};

inline v1::WatchImagesRequest start_of(v1::ImageCodec codec, int width = 64, int height = 48) {
  v1::WatchImagesRequest request;
  v1::WatchImagesStart& start = *request.mutable_start();
  start.set_name("sheets/a");
  start.set_codec(codec);
  start.mutable_view()->set_width_px(width);
  start.mutable_view()->set_height_px(height);
  return request;
}

inline void send(Socket& socket, const v1::WatchImagesRequest& request) {
  socket.send(Socket::kBinary, request.SerializeAsString());
}

inline std::optional<v1::Image> read_image(Socket& socket) {
  const std::optional<Socket::Frame> frame = socket.read();
  v1::WatchImagesResponse response;
  if (!frame || frame->opcode != Socket::kBinary || !response.ParseFromString(frame->payload)) return std::nullopt;
  v1::WatchImagesRequest ack;
  ack.mutable_ack()->set_sequence(response.image().sequence());
  send(socket, ack);
  return response.image();
}

// The next part's picture; empty if the stream ends.
inline std::string read_part(RawClient& client) {
  const std::optional<std::string> head = client.read_until("\r\n\r\n");
  if (!head) return {};
  const std::string key = "Content-Length: ";
  EXPECT_NE(head->find("Content-Type: image/jpeg\r\n"), std::string::npos) << *head;
  const std::size_t at = head->find(key);
  if (at == std::string::npos) return {};
  const std::optional<std::string> picture = client.read_exactly(std::stoul(head->substr(at + key.size())));
  EXPECT_EQ(client.read_until("\r\n--kerf-picture\r\n"), "\r\n--kerf-picture\r\n") << "and nothing in between";
  return picture.value_or("");
}

}  // namespace kerf::ws_test
