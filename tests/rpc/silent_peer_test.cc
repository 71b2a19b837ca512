// A peer that is gone without a word, as when its machine loses power: a bare socket that takes what comes, so that no
// write ever fails, and answers nothing, not even HTTP/2's pings.

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include "kerf/v1/stream.pb.h"
#include "server/service/rpc/rpc_server.h"
#include "tests/api/fixture.h"
#include "tests/ws/raw_client.h"

namespace kerf::rpc_test {
namespace {

enum class FrameType : unsigned char { kData = 0, kHeaders = 1, kSettings = 4, kPing = 6 };  // RFC 9113, section 6

std::string http2_frame(FrameType type, unsigned char flags, unsigned char stream, std::string_view payload) {
  std::string frame;
  for (int shift = 16; shift >= 0; shift -= 8) frame += static_cast<char>(payload.size() >> shift);
  frame += {static_cast<char>(type), static_cast<char>(flags), 0, 0, 0, static_cast<char>(stream)};
  return frame.append(payload);
}

// Literals without indexing, RFC 7541, section 6.2.2; each shorter than 127 bytes.
std::string headers(std::initializer_list<std::pair<std::string_view, std::string_view>> fields) {
  std::string block;
  for (const auto& [name, value] : fields) {
    block += '\0';
    block.append(1, static_cast<char>(name.size())).append(name);
    block.append(1, static_cast<char>(value.size())).append(value);
  }
  return block;
}

// A Watch of sheets/a, opened by hand.
std::string watch_request() {
  v1::WatchRequest start;
  start.mutable_start()->set_name("sheets/a");
  const std::string message = start.SerializeAsString();
  const std::string prefix{0, 0, 0, 0, static_cast<char>(message.size())};  // gRPC's: not compressed, length
  constexpr unsigned char kEndHeaders = 4;
  return "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + http2_frame(FrameType::kSettings, 0, 0, {}) +
         http2_frame(FrameType::kHeaders, kEndHeaders, 1,
                     headers({{":method", "POST"},
                              {":scheme", "http"},
                              {":path", "/kerf.v1.StreamService/Watch"},
                              {":authority", "kerf"},
                              {"content-type", "application/grpc"},
                              {"te", "trailers"}})) +
         http2_frame(FrameType::kData, 0, 1, prefix + message);
}

class SilentPeerTest : public api::ApiTest {};

TEST_F(SilentPeerTest, IsFoundAndItsStreamEnds) {
  using namespace std::chrono_literals;
  ASSERT_TRUE(create_sheet("a", true).ok());
  rpc::RpcOptions options;
  options.keepalive_interval = 300ms;
  options.keepalive_timeout = 300ms;
  rpc::RpcServer server(*api_, clock_, options);
  ws_test::RawClient peer(server.start("127.0.0.1:0").value());
  ASSERT_TRUE(peer.send(watch_request()));
  // The clock stands still: no acknowledgement is owed, and no write is late.
  bool has_watched = false;
  bool was_pinged = false;
  while (const auto head = peer.read_exactly(9)) {
    has_watched = has_watched || api_->num_watchers() == 1;
    const auto byte = [&](std::size_t i) { return static_cast<std::size_t>(static_cast<unsigned char>((*head)[i])); };
    const std::string payload = peer.read_exactly(byte(0) << 16 | byte(1) << 8 | byte(2)).value_or("");
    was_pinged = was_pinged || byte(3) == static_cast<std::size_t>(FrameType::kPing);
  }
  EXPECT_TRUE(has_watched);
  EXPECT_TRUE(was_pinged);
  const auto deadline = std::chrono::steady_clock::now() + 20s;
  while (api_->num_watchers() > 0) ASSERT_LT(std::chrono::steady_clock::now(), deadline);
}

}  // namespace
}  // namespace kerf::rpc_test
