// Readers over a WebSocket whose server is not as it should be.

#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>

#include "client/load/viewer.h"

namespace kerf::load {
namespace {

using namespace std::chrono_literals;
using Tcp = boost::asio::ip::tcp;

class WebSocketViewerTest : public testing::Test {
 protected:
  WebSocketViewerTest() {
    plan_.transport = Transport::kWebSocket;
    plan_.http = "127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port());
  }
  std::unique_ptr<Viewer> viewer(Role role = Role::kViewer) {
    return watch_frames_over_websocket(plan_, {role, "sheets/a", 0, plan_.http, nullptr}, recorder_, stopper_);
  }

  boost::asio::io_context context_;
  Tcp::acceptor acceptor_{context_, {boost::asio::ip::address_v4::loopback(), 0}};
  Plan plan_;
  Recorder recorder_;
  Stopper stopper_;
};

TEST_F(WebSocketViewerTest, OfAServerThatAcceptsAndSaysNothingEndsWhenItIsStopped) {
  const std::unique_ptr<Viewer> reader = viewer();
  const Tcp::socket silent = acceptor_.accept();
  reader->stop();
}

TEST_F(WebSocketViewerTest, StoppedAtOnceItEnds) {
  viewer()->stop();
}

// One vertex and no triangle.
std::string frame_message() {
  v1::WatchResponse response;
  v1::Frame& frame = *response.mutable_frame();
  frame.set_sequence(1);
  frame.set_base_tick(-1);
  frame.set_topology_version(1);
  frame.set_num_vertices(1);
  frame.set_encoding(v1::RAW);
  frame.mutable_box();
  frame.set_positions(std::string(6, '\0'));
  frame.mutable_topology()->set_base_version(-1);
  frame.mutable_topology()->set_num_listed_vertices(1);
  frame.mutable_topology()->set_material_positions(std::string(8, '\0'));
  return response.SerializeAsString();
}

// While the reader holds its first frame the connection is reset, so that the acknowledgement fails.
TEST_F(WebSocketViewerTest, AnAcknowledgementThatFailsIsAnEnd) {
  plan_.hold_s = 0.3;
  const std::unique_ptr<Viewer> reader = viewer(Role::kSlow);
  {
    boost::beast::websocket::stream<Tcp::socket> server(acceptor_.accept());
    server.accept();
    server.binary(true);
    boost::beast::flat_buffer start;
    server.read(start);
    server.write(boost::asio::buffer(frame_message()));
    while (recorder_.readers(Role::kSlow).readers == 0) std::this_thread::sleep_for(1ms);
    server.next_layer().set_option(boost::asio::socket_base::linger(true, 0));
  }
  while (recorder_.readers(Role::kSlow).ends.empty()) std::this_thread::sleep_for(1ms);
  EXPECT_EQ(recorder_.readers(Role::kSlow).ends.size(), 1U);
}

}  // namespace
}  // namespace kerf::load
