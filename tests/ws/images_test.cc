// Image streams of a whole kerfd with its real renderer: WebSocket, MJPEG and single pictures.

#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "kerf/v1/render.pb.h"
#include "tests/ws/images_fixture.h"

namespace kerf::ws_test {
namespace {

TEST_F(ImagesTest, PicturesComeOverAWebSocket) {
  Socket socket(port_, "Sec-WebSocket-Protocol: kerf.v1\r\n", "/images");
  ASSERT_EQ(socket.handshake().status, 101);
  send(socket, start_of(v1::IMAGE_PNG));
  const std::optional<v1::Image> first = read_image(socket);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->data().substr(1, 3), "PNG");
  EXPECT_EQ(first->width_px(), 64);
  step();
  const std::optional<v1::Image> second = read_image(socket);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->sequence(), 2);
  EXPECT_EQ(second->tick(), 1);
  EXPECT_EQ(get("/sheets/a.png?width=64&height=48").body, second->data()) << "the picture that RenderImage draws";
}

TEST_F(ImagesTest, VideoComesOverAWebSocket) {
  if (!video_) GTEST_SKIP() << "built without VP8";
  Socket socket(port_, "Sec-WebSocket-Protocol: kerf.v1\r\n", "/images");
  send(socket, start_of(v1::IMAGE_VP8));
  const std::optional<v1::Image> first = read_image(socket);
  step();
  const std::optional<v1::Image> second = read_image(socket);
  ASSERT_TRUE(first && second);
  EXPECT_TRUE(first->key());
  EXPECT_FALSE(second->key());
  EXPECT_LT(second->data().size(), first->data().size());
}

TEST_F(ImagesTest, WhatIsNoImageProtocolClosesTheSocketWithTheReason) {
  for (const std::string& bytes : {std::string("\xff\xff"), std::string(), [] {
                                     v1::WatchImagesRequest ack;
                                     ack.mutable_ack()->set_sequence(1);
                                     return ack.SerializeAsString();
                                   }()}) {
    Socket socket(port_, "Sec-WebSocket-Protocol: kerf.v1\r\n", "/images");
    socket.send(Socket::kBinary, bytes);
    EXPECT_EQ(socket.read_close(), 1008);
  }
  Socket stranger(port_, "Sec-WebSocket-Protocol: kerf.v1\r\nOrigin: http://evil.example.org\r\n", "/images");
  EXPECT_EQ(stranger.handshake().status, 403);
}

TEST_F(ImagesTest, MjpegHasAPartForEachPicture) {
  RawClient client(port_);
  client.send("GET /sheets/a.mjpeg?width=64&height=48&quality=70&rate=500 HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  const std::optional<std::string> head = client.read_until("\r\n\r\n--kerf-picture\r\n");
  ASSERT_TRUE(head);
  EXPECT_TRUE(head->starts_with("HTTP/1.1 200 OK\r\n"));
  EXPECT_NE(head->find("Content-Type: multipart/x-mixed-replace; boundary=kerf-picture\r\n"), std::string::npos);
  const std::string first = read_part(client);
  EXPECT_EQ(first.substr(0, 2), "\xff\xd8");
  EXPECT_EQ(first, get("/sheets/a.jpg?width=64&height=48&quality=70").body);
  step();
  EXPECT_NE(read_part(client), first);
  EXPECT_NE(get("/metrics").body.find("kerf_image_streams 1\n"), std::string::npos);
  call("SheetService/DeleteSheet", R"({"name":"sheets/a"})");
  EXPECT_TRUE(client.closed_by_peer());
}

TEST_F(ImagesTest, AReaderOfMjpegThatHangsUpIsLetGo) {
  RawClient client(port_);
  client.send("GET /sheets/a.mjpeg HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  ASSERT_TRUE(client.read_until("--kerf-picture\r\n"));
  read_part(client);
  client.hang_up();
  // Soon, though no later than by some thousandth answer.
  bool gone = false;
  for (int i = 0; i < 5000 && !gone; ++i) {
    gone = get("/metrics").body.find("kerf_image_streams 0\n") != std::string::npos;
  }
  EXPECT_TRUE(gone);
}

TEST_F(ImagesTest, BadPictureUrlsSayWhatIsWrong) {
  struct Bad {
    const char* target;
    int status;
    const char* says;
  };
  for (const auto& [target, status, says] :
       std::initializer_list<Bad>{{"/sheets/a.png?width=15", 400, "width is 15; must be 16 to 4096"},
                                  {"/sheets/a.png?width=wide", 400, "width is 'wide'; must be a whole number"},
                                  {"/sheets/a.png?height=4097", 400, "height is 4097; must be 16 to 4096"},
                                  {"/sheets/a.jpg?quality=101", 400, "quality is 101; must be 1 to 100"},
                                  {"/sheets/a.jpg?color=mood", 400, "sides, pieces or strains"},
                                  {"/sheets/a.jpg?wireframe=yes", 400, "0 or 1"},
                                  {"/sheets/a.jpg?dark=yes", 400, "0 or 1"},
                                  {"/sheets/a.jpg?rate=3", 400, "unknown parameter 'rate'"},
                                  {"/sheets/nobody.png", 404, "nobody"},
                                  {"/sheets/A.png", 400, "sheets/"},
                                  {"/sheets/.png", 404, "nothing at"},
                                  {"/sheets/a.gif", 404, "nothing at"},
                                  {"/sheets/a.mjpeg?width=15", 400, "width is 15; must be 16 to 4096"},
                                  {"/sheets/a.mjpeg?quality=-1", 400, "quality is -1; must be 1 to 100"},
                                  {"/sheets/a.mjpeg?rate=1001", 400, "rate is 1001; must be 0.001 to 1000"},
                                  {"/sheets/a.mjpeg?rate=fast", 400, "rate is 'fast'"},
                                  {"/sheets/a.mjpeg?codec=vp8", 400, "unknown parameter 'codec'"},
                                  {"/sheets/nobody.mjpeg", 404, "nobody"}}) {
    const Response answer = get(target);
    EXPECT_EQ(answer.status, status) << target << answer.body;
    EXPECT_NE(answer.body.find(says), std::string::npos) << target << answer.body;
  }
  EXPECT_EQ(request(port_, "GET", "/sheets/a.png", "Host: rebound.example.org\r\n").status, 403);
  EXPECT_EQ(request(port_, "GET", "/sheets/a.mjpeg", "Host: rebound.example.org\r\n").status, 403);
  EXPECT_EQ(request(port_, "HEAD", "/sheets/a.mjpeg").status, 405);
}

}  // namespace
}  // namespace kerf::ws_test
